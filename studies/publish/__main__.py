"""`python -m studies.publish`: makes again what docs/ publishes of other code, or only looks.

Studies are carried out one after the other, what took least first; those that keep what they have
done go on after an interruption. How long each takes is what it took last, on one processor.
"""

import subprocess
import sys
from typing import Annotated

import typer

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.files import write_file
from drake_linefoot.lab.results.tables import NOTHING, number_table, wide_console
from studies.bench.page import write as write_bench_page
from studies.common.command import BROKE_OFF, DOCS, OUT, run
from studies.common.files import write_text
from studies.publish.page import PAGE, page_of
from studies.publish.results import RESULTS, Result
from studies.publish.standing import Standing, State, cheapest_first, standing

HEAD = ("result", "state", "why", "hours")
GOOD = (State.FRESH, State.AGREES, State.OF_A_MACHINE)


def publish(
    name: Annotated[
        list[str] | None, typer.Argument(metavar="RESULT...", help="Only these; else all.")
    ] = None,
    redraw: Annotated[bool, typer.Option("--page", help="Only write the page anew.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Make nothing; fail where something is stale.")
    ] = False,
    stale: Annotated[
        bool, typer.Option("--stale", help="Only what does not agree with its quick form.")
    ] = False,
) -> None:
    """Make again, cheapest first, what docs/ publishes of other code than this."""
    screen, wanted = wide_console(), chosen(name)
    if redraw:
        write_page(list(RESULTS))
        return
    found = cheapest_first(standing(one, quick_forms=check or stale) for one in wanted)
    screen.print(number_table(HEAD, [row_of(one) for one in found], words=3, wrapped="why"))
    left = [one for one in found if one.state not in (GOOD if check or stale else GOOD[:1])]
    if check and left:
        raise typer.Exit(BROKE_OFF)
    if check:
        return
    for one in left:
        screen.print(f"{one.result.target} ...", markup=False)
        make(one.result)
        write_page(list(RESULTS))


def write_page(results: list[Result]) -> None:
    """Write the page of results.

    Raises:
        InputError: the data of one cannot be read.
        OutputError: the page cannot be written.
    """
    try:
        text = page_of(results)
    except (OSError, ValueError) as error:
        raise InputError("studies.publish", "", str(DOCS), f"cannot be read: {error}") from error
    write_text(DOCS / PAGE, text)


def chosen(names: list[str] | None) -> list[Result]:
    """Return the results of some names, or all.

    Raises:
        InputError: there is none of a name.
    """
    known = {one.target: one for one in RESULTS}
    for name in names or ():
        if name not in known:
            raise InputError("studies.publish", "RESULT", name, f"must be one of {list(known)}")
    return [known[name] for name in names or known]


def row_of(one: Standing) -> list[str]:
    """Return the cells of a result, see `HEAD`."""
    hours = NOTHING if one.seconds is None else f"{one.seconds / 3600.0:.2f}"
    return [one.result.target, one.state.value, one.why or NOTHING, hours]


def make(result: Result) -> None:
    """Carry out a study, and publish what it wrote.

    Raises:
        LinefootError: it failed.
    """
    words = ["make", "--no-print-directory", result.target, "ARGS="]  # not those of `publish`
    status = subprocess.run(words, check=False)
    if status.returncode:
        raise LinefootError(f"make {result.target} ended with status {status.returncode}")
    if result.made_in:
        copy(result)
    if result.target == "bench":
        write_bench_page(DOCS / result.data, DOCS / result.page)


def copy(result: Result) -> None:
    """Copy what a study has written elsewhere to where it is published.

    Raises:
        OutputError: it cannot be written.
    """
    data = DOCS / result.data
    for pattern in (data.name, *result.copied):
        for path in sorted((OUT / result.made_in).glob(pattern)):
            write_file(data.parent / path.name, path.read_bytes())


if __name__ == "__main__":
    sys.exit(run(publish, "publish"))
