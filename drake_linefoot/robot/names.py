"""The joints, bodies and frames of one robot by name, in a plant where others have names, too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, ModelInstanceIndex, RigidBody

_SCOPE = "::"  # between the name of a model, or of one inside another, and that of a part
Part = TypeVar("Part", Joint, RigidBody, Frame)


class Names:
    """Finds the parts of a robot.

    A name is looked for in the models that the robot's file has made. Where more than one of them
    has it, it is the main one's, or its scope says whose it is: "left_leg::knee".

    Attributes:
        plant: where the robot is.
        instances: models that the file has made.
        root: the main one, with the torso.
    """

    def __init__(
        self, plant: MultibodyPlant, instances: Sequence[ModelInstanceIndex], base: str
    ) -> None:
        """Take the models of a robot whose torso is the body `base`."""
        self.plant, self.instances, self.root = plant, tuple(instances), instances[0]
        fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
        places = self._places(plant.HasBodyNamed, base)
        free = [place for place in places if plant.GetBodyByName(*place).index() not in fixed]
        if places:
            self.root = (free or places)[0][1]

    def joint(self, name: str) -> Joint:
        """Return a joint; RuntimeError when there is none."""
        return self._get(self.plant.HasJointNamed, self.plant.GetJointByName, name)

    def body(self, name: str) -> RigidBody:
        """Return a body; RuntimeError when there is none."""
        return self._get(self.plant.HasBodyNamed, self.plant.GetBodyByName, name)

    def frame(self, name: str) -> Frame:
        """Return a frame; RuntimeError when there is none."""
        return self._get(self.plant.HasFrameNamed, self.plant.GetFrameByName, name)

    def has_joint(self, name: str) -> bool:
        """Whether there is a joint of that name."""
        return bool(self._places(self.plant.HasJointNamed, name))

    def has_body(self, name: str) -> bool:
        """Whether there is a body of that name."""
        return bool(self._places(self.plant.HasBodyNamed, name))

    def has_frame(self, name: str) -> bool:
        """Whether there is a frame of that name."""
        return bool(self._places(self.plant.HasFrameNamed, name))

    def joints(self) -> list[Joint]:
        """Return all joints of the robot."""
        joints = [self.plant.get_joint(index) for index in self.plant.GetJointIndices()]
        return [joint for joint in joints if joint.model_instance() in self.instances]

    def name_of(self, part: Joint | RigidBody | Frame) -> str:
        """Return the name by which a part of the robot is found, with a scope if it needs one."""
        name: str = part.name()
        has = self.plant.HasJointNamed if isinstance(part, Joint) else self.plant.HasBodyNamed
        places = self._places(has, name)
        if not places or places[0][1] == part.model_instance():
            return name
        scope = self._model(part.model_instance())
        return scope.removeprefix(self._model(self.root) + _SCOPE) + _SCOPE + name

    def _model(self, instance: ModelInstanceIndex) -> str:
        name: str = self.plant.GetModelInstanceName(instance)
        return name

    def _places(
        self, has: Callable[[str, ModelInstanceIndex], bool], name: str
    ) -> list[tuple[str, ModelInstanceIndex]]:
        """Return where a name is, and by which name there; the main model first."""
        order = sorted(self.instances, key=lambda instance: instance != self.root)
        found = [(name, instance) for instance in order if has(name, instance)]
        scope, _, local = name.rpartition(_SCOPE)
        if found or not scope:
            return found
        inside = [i for i in order if (_SCOPE + self._model(i)).endswith(_SCOPE + scope)]
        return [(local, instance) for instance in inside if has(local, instance)]

    def _get(
        self,
        has: Callable[[str, ModelInstanceIndex], bool],
        get: Callable[[str, ModelInstanceIndex], Part],
        name: str,
    ) -> Part:
        places = self._places(has, name)
        return get(*places[0]) if places else get(name, self.root)
