"""The models of the MPC by their names: what scenario, command line and drive choose from."""

from types import MappingProxyType

from drake_linefoot.errors import InputError
from drake_linefoot.mpc.models.contact_consistent import CONTACT_CONSISTENT
from drake_linefoot.mpc.models.ecd import ECD
from drake_linefoot.mpc.models.model import Model
from drake_linefoot.mpc.models.single_body import SINGLE_BODY, SINGLE_BODY_MOMENTUM

_SHIPPED = (ECD, CONTACT_CONSISTENT, SINGLE_BODY, SINGLE_BODY_MOMENTUM)
_MODELS = {model.name: model for model in _SHIPPED}
MODELS = MappingProxyType(_MODELS)  # all that are registered, as of now


def register(model: Model) -> None:
    """Make a model of one's own known by its name, in this process.

    Raises:
        InputError: the name is taken.
    """
    if model.name in _MODELS:
        taken = f"is taken; must not be one of {list(_MODELS)}"
        raise InputError("model of the MPC", "name", model.name, taken)
    _MODELS[model.name] = model


def model_named(name: str) -> Model:
    """Return the model of a name.

    Raises:
        InputError: there is none.
    """
    if name not in _MODELS:
        raise InputError("mpc.model", "", name, f"must be one of {list(_MODELS)}")
    return _MODELS[name]
