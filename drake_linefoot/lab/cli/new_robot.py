"""The command `linefoot new-robot`. Drake is imported inside it."""

from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.files import writing
from drake_linefoot.lab.cli.screen import say
from drake_linefoot.lab.simulation.drake_logging import silence_drake

PICTURE = "robot.png"


def _contact(text: str) -> str:
    """Return how feet are to touch."""
    from drake_linefoot.robot.description import LINE, SURFACE

    if text not in (LINE, SURFACE):
        why = ": on points a robot cannot stand still" if text == "point" else ""
        raise typer.BadParameter(f"{text!r} must be {LINE} or {SURFACE}{why}")
    return text


def new_robot(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="URDF, or what Drake parses.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder to write; else the model's name.")
    ] = None,
    lock_arms: Annotated[
        bool, typer.Option("--lock-arms", help="Weld the arms to the torso, too.")
    ] = False,
    contact: Annotated[
        str | None,
        typer.Option(
            parser=_contact,
            metavar="line|surface",
            help="How feet touch; line locks the ankle roll. Else as legs and soles allow.",
        ),
    ] = None,
) -> None:
    """Describe a robot from its model: write a folder for `linefoot walk --robot DIR`."""
    from drake_linefoot.lab.new_robot.analysis import analyse
    from drake_linefoot.lab.new_robot.folder import check_new, write_folder
    from drake_linefoot.lab.results.poses import draw_robot, png
    from drake_linefoot.robot.humanoid import load_humanoid

    folder = Path(model.stem) if out is None else out
    check_new(folder)
    silence_drake()
    found = analyse(model, lock_arms, contact)
    for line in found.lines:
        say(line)
    write_folder(folder, found)
    picture = folder / PICTURE
    with writing(picture):
        picture.write_bytes(png(draw_robot(load_humanoid(folder))))
    say(f"{picture}: the robot as it was found")
    say(f"{folder}: now linefoot walk --robot {folder}")
