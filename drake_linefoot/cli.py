"""The command `linefoot`: parses, calls, prints.

Drake is imported inside the commands, so that `linefoot --help` is quick.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot import __version__
from drake_linefoot.cli_drive import drive
from drake_linefoot.cli_inspect import draw, log, show
from drake_linefoot.cli_options import (
    Duration,
    Forward,
    Left,
    Model,
    Rate,
    ScenarioName,
    Seed,
    Turn,
)
from drake_linefoot.cli_sweep import contact_study, robustness, sweep
from drake_linefoot.errors import InputError, LinefootError, OutputError
from drake_linefoot.simulation.quiet import quieten_drake

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

    from drake_linefoot.scenario import Scenario

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED = 0, 1, 2, 3, 130
STATUS = (
    "Exit status: 0 fine; 1 the robot fell (everything is written); 2 bad input; "
    "3 the run broke off; 130 interrupted. Nothing is ever half-written."
)

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    help="A line-foot humanoid walks in Drake.",
    epilog=STATUS,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status.

    Args:
        arguments: words after the program's name; None takes those of the process.
    """
    try:
        status = app(args=arguments, prog_name="linefoot", standalone_mode=False)
    except typer.BadParameter as error:
        return _complain(error.format_message(), BAD_INPUT)
    except typer.TyperException as error:
        return _complain(f"{error.format_message()} (see linefoot --help)", BAD_INPUT)
    except (InputError, OutputError) as error:
        return _complain(str(error), BAD_INPUT)
    except LinefootError as error:
        return _complain(str(error), BROKE_OFF)
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    if status == INTERRUPTED:
        return _complain("interrupted", INTERRUPTED)
    return int(status or FINE)


@app.callback(invoke_without_command=True)
def start(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show versions and exit.")] = False,
) -> None:
    """Say what there is when no command is given."""
    if version:
        from importlib.metadata import version as version_of

        typer.echo(f"drake_linefoot {__version__}, Drake {version_of('drake')}")
        raise typer.Exit(FINE)
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(FINE)


@app.command(epilog=STATUS)
def walk(
    scenario: ScenarioName = "walk",
    duration: Duration = None,
    vx: Forward = None,
    vy: Left = None,
    turn: Turn = None,
    seed: Seed = None,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("out/walk"),
    model: Model = None,
    live: Annotated[bool, typer.Option("--live", help="Show it in a browser meanwhile.")] = False,
    replay: Annotated[bool, typer.Option(help="Write replay.html.")] = True,
) -> None:
    """Simulate a scenario; write replay, log, plots and metrics."""
    from drake_linefoot.scenario_edit import with_command, with_duration
    from drake_linefoot.scenario_io import load_scenario
    from drake_linefoot.simulation.output import check_output_dir

    overrides = {"seed": seed, "mpc.model": model}
    given = {field: value for field, value in overrides.items() if value is not None}
    run = load_scenario(scenario, given)
    if (vx, vy, turn) != (None, None, None):
        run = with_command(run, vx or 0.0, vy or 0.0, turn or 0.0)
    if duration is not None:
        run = with_duration(run, duration)
    check_output_dir(out)
    if not _simulate(run, out, live, replay):
        raise typer.Exit(FELL)


app.command(epilog=STATUS)(drive)
app.command()(log)
app.command()(draw)
app.command()(show)
app.command(epilog=STATUS)(sweep)
app.command(epilog=STATUS)(robustness)
app.command()(contact_study)


@app.command("replay")
def replay_run(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `linefoot walk` wrote.")],
    loop_once: Annotated[bool, typer.Option("--loop-once", help="Show it once and end.")] = False,
    rate: Rate = 1.0,
) -> None:
    """Show a recorded run in a browser, over and over, until Ctrl-C."""
    from drake_linefoot.simulation.recording import Run
    from drake_linefoot.visualization.replay import play

    quieten_drake()
    run = Run.load(folder)
    meshcat = open_meshcat(live=True)
    play(run, meshcat, rate)
    while not loop_once:
        play(run, meshcat, rate)


@app.command(epilog=STATUS)
def paper(
    figure: Annotated[
        str | None, typer.Argument(metavar="FIGURE", help="Only this one; else all.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("out/paper"),
    quick: Annotated[bool, typer.Option("--quick", help="Shorter runs.")] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Compute what is there again.")] = False,
) -> None:
    """Reproduce the paper's figures; write pictures, data, claims.json and index.html."""
    from rich.console import Console

    from drake_linefoot.evaluation.paper import PAGE, write_paper

    quieten_drake()
    console = Console(highlight=False)
    upright = write_paper(figure, out, quick=quick, fresh=fresh, console=console)
    typer.echo(str(out / PAGE))
    if not upright:
        raise typer.Exit(FELL)


@app.command()
def envelope(
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("out/paper"),
    quick: Annotated[bool, typer.Option("--quick", help="Shorter runs, coarser steps.")] = False,
) -> None:
    """Find the fastest commands that are walked; write envelope.json and envelope.png."""
    from rich.console import Console

    from drake_linefoot.evaluation.envelope import main_envelope

    quieten_drake()
    main_envelope(out, quick=quick, console=Console(highlight=False))


@app.command()
def bench(
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("out/bench"),
    quick: Annotated[bool, typer.Option("--quick", help="Less of everything.")] = False,
    placo: Annotated[
        Path | None, typer.Option(metavar="PYTHON", help="Interpreter that has PlaCo 0.10.")
    ] = None,
) -> None:
    """Measure speed and memory, beside other packages; write bench.json."""
    from rich.console import Console

    from drake_linefoot.benchmark.bench import main_bench

    quieten_drake()
    main_bench(out, quick=quick, placo=placo, console=Console(highlight=False))


def _simulate(scenario: Scenario, out: Path, live: bool, replay: bool) -> bool:
    """Simulate, write and print; return whether the robot stayed up."""
    from rich.console import Console

    from drake_linefoot.results import tables
    from drake_linefoot.simulation.metrics import compute_metrics
    from drake_linefoot.simulation.output import REPLAY, write_outputs
    from drake_linefoot.simulation.run import simulate
    from drake_linefoot.simulation.warm_up import warm_up
    from drake_linefoot.visualization.replay import recording, replay_html, run_title
    from drake_linefoot.wiring.closed_loop import build_closed_loop

    quieten_drake()
    console = Console(highlight=False)
    warm_up(console.print)
    meshcat = open_meshcat(live) if live or replay else None
    loop = build_closed_loop(scenario, meshcat)
    recorded = recording(meshcat) if meshcat and replay else nullcontext()
    with tables.progress_bar(console) as progress, recorded:
        run = simulate(loop, progress, realtime_rate=1.0 if live else 0.0)
    page = replay_html(meshcat, run_title(run)) if meshcat and replay else None
    write_outputs(run, page, out)
    metrics = compute_metrics(run)
    console.print(tables.segment_table(metrics), tables.summary_table(metrics))
    if run.fell:
        console.print(f"The robot FELL at {run.fall_time:.3f} s: {run.fall_reason}", markup=False)
    typer.echo(str(out / REPLAY if replay else out))
    return not run.fell


def open_meshcat(live: bool) -> Meshcat:
    """Open a Meshcat server, and say where when it is for looking at."""
    from pydrake.geometry import Meshcat, MeshcatParams

    try:
        meshcat = Meshcat(MeshcatParams(host="*" if live else "localhost", show_stats_plot=False))
    except RuntimeError as error:
        raise LinefootError(f"Meshcat cannot open a port: {error}") from error
    if live:
        typer.echo(f"Live at {meshcat.web_url()}")
    return meshcat


def _complain(message: str, status: int) -> int:
    """Print one line on stderr; return the exit status."""
    print("linefoot:", " ".join(message.split()), file=sys.stderr)
    return status
