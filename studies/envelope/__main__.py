"""`python -m studies.envelope`: the fastest commands that are walked."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.lab.results.tables import number_table, wide_console
from studies.common.command import Fresh, Out, Quick, run
from studies.common.files import prepare, write_json, write_picture
from studies.common.runs import MODELS
from studies.common.stamp import stamped
from studies.common.types import Data
from studies.envelope.envelope import (
    DONE,
    DURATION,
    JSON,
    PICTURE,
    QUICK_DURATION,
    QUICK_MODELS,
    Walks,
    draw,
    measure,
    table,
)
from studies.envelope.probe import probe
from studies.envelope.walks import AXES


def envelope(
    model: Annotated[
        list[str] | None, typer.Option(help=f"Of the MPC: {', '.join(MODELS)}; else all of them.")
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option(help=f"Of the commands: {', '.join(AXES)}; else all of them."),
    ] = None,
    out: Out = Path("out/paper"),
    quick: Quick = False,
    fresh: Fresh = False,
) -> None:
    """Find the fastest commands that are walked; write envelope.json and envelope.png."""
    models, axes = model or (QUICK_MODELS if quick else list(MODELS)), axis or list(AXES)
    for hint, names, known in (("--model", models, MODELS), ("--axis", axes, AXES)):
        for name in names:
            if name not in known:
                raise typer.BadParameter(f"{name!r} must be one of {list(known)}", param_hint=hint)
    screen = wide_console()
    prepare(out)
    file, duration = (out / DONE.name, QUICK_DURATION) if quick else (DONE, DURATION)
    walks = Walks(file, duration, fresh)
    data: Data = {}
    with screen.status("measuring") as status:

        def report(text: str) -> None:
            status.update(text)
            if not screen.is_terminal:
                screen.print(text, markup=False)

        for found in measure(models, axes, quick, report, walks):
            data = found | stamped("envelope", found["seconds"], None if quick else probe)
            write_json(out / JSON, data)
            write_picture(out / PICTURE, draw(data))
    header, *rows = table(data)
    screen.print(number_table(header, rows, wrapped=header[-1]))


if __name__ == "__main__":
    sys.exit(run(envelope, "envelope"))
