"""The models of the MPC by their names: what scenario, command line and drive choose from.

A file of a scenario is checked by the names alone; a model is loaded when it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

from drake_linefoot.errors import InputError

if TYPE_CHECKING:
    from drake_linefoot.mpc.models.model import Model

_SHIPPED = {  # name -> module beside this one, and what the model is called there
    "ecd": ("ecd", "ECD"),
    "contact_consistent": ("contact_consistent", "CONTACT_CONSISTENT"),
    "srbm": ("single_body", "SINGLE_BODY"),
    "srbm_momentum": ("single_body", "SINGLE_BODY_MOMENTUM"),
}


class _Models(Mapping[str, "Model"]):
    """All that are known, as of now."""

    def __init__(self) -> None:
        self.own: dict[str, Model] = {}

    def __getitem__(self, name: str) -> Model:
        if name in self.own:
            return self.own[name]
        module, attribute = _SHIPPED[name]
        model: Model = getattr(import_module(f"{__package__}.{module}"), attribute)
        return model

    def __contains__(self, name: object) -> bool:
        return name in _SHIPPED or name in self.own

    def __iter__(self) -> Iterator[str]:
        return iter((*_SHIPPED, *self.own))

    def __len__(self) -> int:
        return len(_SHIPPED) + len(self.own)


MODELS = _Models()


def register(model: Model) -> None:
    """Make a model of one's own known by its name, in this process.

    Raises:
        InputError: the name is taken.
    """
    if model.name in MODELS:
        taken = f"is taken; must not be one of {list(MODELS)}"
        raise InputError("model of the MPC", "name", model.name, taken)
    MODELS.own[model.name] = model


def model_named(name: str) -> Model:
    """Return the model of a name.

    Raises:
        InputError: there is none.
    """
    if name not in MODELS:
        raise InputError("mpc.model", "", name, f"must be one of {list(MODELS)}")
    return MODELS[name]
