"""Every example runs, prints what it says and writes what it promises."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
# Arguments that keep it short; the file it writes; a word it prints.
RUNS = {
    "01_show_robot.py": (["--html", "out.html"], "out.html", "18 joints"),
    "02_balance.py": (["--duration", "1.0"], None, "largest sway"),
    "03_plan_only.py": (["--out", "plan.png"], "plan.png", "solver in "),
    "04_walk.py": (["--seconds", "0.8", "--out", "out.html"], "out.html", "fell: False"),
    "05_own_block.py": (["--duration", "1.0"], None, "fell: False"),
    "06_own_diagram.py": (["--seconds", "0.5"], None, "torso at"),
    "07_learn.py": (["--rounds", "1", "--seconds", "0.5"], None, "learned"),
    "08_own_task.py": (["--seconds", "2.0"], None, "fell: False; arm at -2.6"),
    "09_own_model.py": (["--seconds", "0.5"], None, "frozen_inertia walked"),
    "10_own_contact.py": (["--seconds", "2.0"], None, "22 rows; fell: False"),
    "11_own_loop.py": ([], None, "torso at"),
}


def test_every_example_is_run_here():
    assert [path.name for path in EXAMPLES] == sorted(RUNS)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_is_short_and_says_what_it_shows(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= (60 if "_own_" in path.name and path.name > "07" else 90)
    assert text.startswith('"""') and "python examples/" + path.name in text


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_runs(path, tmp_path):
    arguments, written, word = RUNS[path.name]
    done = subprocess.run(
        [sys.executable, str(path), *arguments],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert word in done.stdout
    if written is not None:
        assert (tmp_path / written).stat().st_size > 10_000


@pytest.mark.slow
def test_python_in_the_readme_runs(tmp_path):
    readme = (FOLDER.parent / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert len(code.strip().splitlines()) <= 15
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=True)
    walked, built = done.stdout.splitlines()
    for line in (walked, built):
        said = line.removeprefix("False").removesuffix(" m")
        forward, left, height = (float(x) for x in said.strip(" []\n").split())
        assert forward > 0.5 and left > 0.0 and 0.6 < height < 0.7
