"""The command `linefoot`, and `python -m drake_linefoot`."""

import signal
import sys
from contextlib import suppress
from importlib.util import find_spec
from threading import Timer, main_thread
from types import FrameType

from drake_linefoot.errors import MissingPackageError

SOON = 0.01  # [s] until a Ctrl-C comes again


def main() -> int:
    """Run the command; say what to install where the laboratory that it belongs to is not."""
    show_no_interrupts()
    if find_spec("typer") is None:
        print(MissingPackageError("linefoot", "typer"), file=sys.stderr)
        return 2
    from drake_linefoot.lab.cli import main as command

    return command()


def show_no_interrupts() -> None:
    """Let no Ctrl-C of this process show a traceback, not even while it loads or ends.

    One that nobody catches ends it with a line. One that Python drops, as in a destructor or in
    what an import calls back, would only be shown, and the program go on: it comes again. So does
    one while Drake loads, which would show where it was.
    """
    uncaught, dropped = sys.excepthook, sys.unraisablehook

    def on_uncaught(kind: type[BaseException], error: BaseException, *trace: object) -> None:
        if not issubclass(kind, KeyboardInterrupt):
            return uncaught(kind, error, *trace)  # type: ignore[arg-type]
        with suppress(OSError, ValueError):  # there may be nobody to tell
            print("linefoot: interrupted", file=sys.stderr)

    def on_dropped(what: "sys.UnraisableHookArgs") -> None:
        if not issubclass(what.exc_type, KeyboardInterrupt):
            return dropped(what)
        _interrupt_soon()

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        drake = getattr(sys.modules.get("pydrake"), "__spec__", None)
        if not getattr(drake, "_initializing", False):
            signal.default_int_handler(number, frame)
        _interrupt_soon()

    sys.excepthook, sys.unraisablehook = on_uncaught, on_dropped
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else it is ignored
        signal.signal(signal.SIGINT, on_interrupt)


def _interrupt_soon() -> None:
    thread = main_thread().ident or 0  # a signal to it ends what it waits for, as a Ctrl-C does
    again = Timer(SOON, signal.pthread_kill, (thread, signal.SIGINT))
    again.daemon = True
    with suppress(RuntimeError):  # at the very end no thread begins any more
        again.start()


if __name__ == "__main__":
    sys.exit(main())
