"""What a sweep shows while it goes on: a bar for each group, with its success rate so far."""

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from drake_linefoot.sweep.file import Sweep
from drake_linefoot.sweep.rows import Row, upright

TENTHS = 10  # of a sweep; at each one a line is printed where no bar can be shown


class Board(Progress):
    """Shows how far a sweep is, inside a `with` block."""

    def __init__(self, sweep: Sweep, console: Console) -> None:
        """Show the groups of `sweep` on `console`."""
        super().__init__(
            TextColumn("{task.fields[group]}"),
            BarColumn(bar_width=20),
            MofNCompleteColumn(),
            TextColumn("{task.description}"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        names = [group.name for group in sweep.groups]
        self._total = sweep.runs * len(names)
        self._good = dict.fromkeys(names, 0)
        self._done = dict.fromkeys(names, 0)
        self._bars = {n: self.add_task("", total=sweep.runs, group=escape(n)) for n in names}

    def count(self, row: Row, before: bool = False) -> None:
        """Count a run; `before` for one that was done when the sweep began."""
        group = row["group"]
        self._done[group] += 1
        self._good[group] += upright(row)
        rate = self.rate(group)
        self.update(self._bars[group], completed=self._done[group], description=rate)
        done = sum(self._done.values())
        tenth = done * TENTHS // self._total > (done - 1) * TENTHS // self._total
        if tenth and not before and not self.console.is_terminal:
            rates = ", ".join(f"{name} {self.rate(name)}" for name in self._good)
            self.report(f"{done} of {self._total} runs: {rates}")

    def rate(self, group: str) -> str:
        """Return the success rate of a group so far, in words."""
        if not self._done[group]:
            return "-"
        return f"{100.0 * self._good[group] / self._done[group]:.1f} % upright"

    def report(self, text: str) -> None:
        """Print a line above the bars."""
        self.console.print(text, markup=False)
