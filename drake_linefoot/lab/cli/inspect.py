"""The commands that look into things: `log`, `draw`, `show`. Drake is imported inside them."""

from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.lab.cli.options import Host, Port, Robot
from drake_linefoot.lab.cli.screen import busy, open_live, say, until_interrupted
from drake_linefoot.lab.simulation.drake_logging import silence_drake
from drake_linefoot.resources import PACKAGE

DRAWINGS = Path("out/diagrams")


def draw(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME|SYSTEM",
            help="A scenario, drawn whole, or one system: controller, ecd_mpc, ...",
        ),
    ] = "walk",
    of: Annotated[
        str, typer.Option("--of", metavar="SCENARIO", help="Where a system is taken from.")
    ] = "walk",
    out: Annotated[
        Path | None,
        typer.Option(help=f"Folder; else beside your scenario, or {DRAWINGS}."),
    ] = None,
    png: Annotated[bool, typer.Option("--png", help="Write NAME.png as well.")] = False,
    ports: Annotated[
        bool, typer.Option("--ports", help="Print the tables of the ports instead.")
    ] = False,
) -> None:
    """Draw a closed loop, its controller or one block: NAME.svg, NAME.txt with its connections."""
    from drake_linefoot.lab.wiring.draw import draw as draw_picture
    from drake_linefoot.lab.wiring.draw import picture_of

    silence_drake()
    picture = picture_of(name, of)
    if ports:
        typer.echo(picture.ports, nl=False)
        return
    beside = DRAWINGS if picture.file is None else picture.file.parent
    if beside.is_relative_to(PACKAGE):  # that of a wheel, which is not ours to write to
        beside = DRAWINGS
    for path in draw_picture(picture, out or beside, png=png):
        typer.echo(str(path))
        if path.suffix == ".dot":
            typer.echo("pygraphviz is not installed, so the drawing is not rendered")


def log(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `linefoot walk` wrote.")],
    mcap: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the run as MCAP to this file.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Of its messages; else 200, see --mcap.")
    ] = None,
) -> None:
    """Print the channels of a run: units, shapes, rates, sizes; or write its MCAP log anew."""
    from drake_linefoot.files import new_file
    from drake_linefoot.lab.results.tables import log_table, wide_console
    from drake_linefoot.lab.simulation.mcap_log import RATE, write_mcap
    from drake_linefoot.lab.simulation.recording import UNFINISHED, Run, log_of

    if mcap is not None:
        run = Run.load(folder)
        with new_file(mcap) as file:
            write_mcap(run, file, RATE if rate is None else rate)
        typer.echo(str(mcap))
        return
    if rate is not None:
        raise typer.BadParameter("needs --mcap", param_hint="'--rate'")
    wide_console().print(log_table(folder))
    if not Run.load(folder).ended:
        typer.echo("the run has not ended: it was killed, broke off or goes on")
    part = folder.with_name(folder.name + UNFINISHED) if folder.name else folder
    if part != folder and part.is_dir() and log_of(folder).parent == folder:
        typer.echo(f"{part} has a later run, which has not ended")


def show(
    model: Annotated[
        str,
        typer.Argument(metavar="MODEL", help="A robot: mit_humanoid, a folder, a YAML file."),
    ] = "mit_humanoid",
    robot: Robot = None,
    loop_once: Annotated[bool, typer.Option("--loop-once", help="Show it and end.")] = False,
    host: Host = None,
    port: Port = None,
    inside: Annotated[
        bool, typer.Option("--inside", help="See-through, with frames and inertia ellipsoids.")
    ] = False,
) -> None:
    """Show a robot in a browser, with a slider for every joint; Ctrl-C ends it."""
    silence_drake()
    with busy("loading the robot"):
        from drake_linefoot.lab.visualization.show import show as show_robot
        from drake_linefoot.robot.humanoid import load_humanoid

        humanoid = load_humanoid(robot or model)
    for note in humanoid.notes:
        say(note)
    press = "Drag its sliders; R is the nominal posture, I looks inside"
    with open_live(host, port, press=press) as page, until_interrupted():
        show_robot(humanoid, page, inside, loop_once)
