"""Make requirements/ anew from pyproject.toml: `make lock`, with options of uv in ARGS.

Each file has what one part of the environment needs with the sha256 of all files of each release,
for every system and Python. Versions stay as they are unless ARGS asks for others: `--upgrade`,
or `--upgrade-package numpy`.
"""

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMPILE = (
    *(sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--universal"),
    *("--python-version", "3.11", "--generate-hashes", "--no-annotate"),
    *("--only-binary", ":all:", "--emit-build-options"),  # what builds a file would be unchecked
    *("--custom-compile-command", "make lock"),
)


def needs() -> dict[str, list[str]]:
    """Requirements of each part: `base` is the package, its build and the lab."""
    content = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project, extras = content["project"], content["project"]["optional-dependencies"]
    return {
        "base": content["build-system"]["requires"] + project["dependencies"] + extras["lab"],
        "dev": extras["dev"] + extras["studies"],
        **{part: extras[part] for part in ("docs", "bench", "qpbenchmark", "zoo", "smoother")},
    }


def main() -> None:
    """Lock one part after the other, each with the versions of those before it."""
    locked: list[str] = []
    for part, requirements in needs().items():
        file = f"requirements/{part}.txt"
        command = (*COMPILE, *locked, *sys.argv[1:], "--output-file", file, "-")
        text = "\n".join(requirements)
        done = subprocess.run(
            command, input=text, text=True, cwd=ROOT, check=False, stdout=subprocess.DEVNULL
        )
        if done.returncode:
            sys.exit(f"{file} is left as it was")  # uv has said why
        locked += ["--constraints", file]


if __name__ == "__main__":
    main()
