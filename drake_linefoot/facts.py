"""What an object shows of itself at a prompt and in a notebook: a title and a few facts."""

from collections.abc import Mapping
from html import escape


class WithFacts:
    """Shows a title and facts, where a dataclass would show every number it has."""

    def _title(self) -> str:
        raise NotImplementedError

    def _facts(self) -> Mapping[str, object]:
        """Return what is said of it, by what it is."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """Return one line for the title, and one for each fact."""
        facts = [(name, str(value)) for name, value in self._facts().items()]
        width = max(len(name) for name, _ in facts)
        return "\n".join([self._title(), *(f"  {name:{width}}  {value}" for name, value in facts)])

    def _repr_html_(self) -> str:
        """Return the same as a table, which Jupyter shows."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(name)}</th>"
            f"<td style='text-align:left'>{escape(str(value))}</td></tr>"
            for name, value in self._facts().items()
        )
        return f"<table><caption>{escape(self._title())}</caption>{rows}</table>"
