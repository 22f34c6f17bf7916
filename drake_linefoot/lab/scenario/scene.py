"""The scene of a scenario: what the ground is like, read from a file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, TypeVar

from annotated_types import Len
from pydantic import Strict

from drake_linefoot.checks import check, plain, shown
from drake_linefoot.errors import InputError, ScenarioError
from drake_linefoot.fields import Number, Pair, Share, Triple, Unit, misfit, together
from drake_linefoot.lab.scenario.courses import (
    BlocksParameters,
    CourseParameters,
    GapsParameters,
    PatchParameters,
    SpiralParameters,
    StairsParameters,
    StonesParameters,
)
from drake_linefoot.lab.scenario.disturbances import (
    MOST_PATCHES,
    Angle,
    Dissipation,
    Edge,
    Height,
    Metres,
    Slope,
    Stiffness,
)
from drake_linefoot.lab.scenario.schema import Scenario
from drake_linefoot.parameters import Parameters
from drake_linefoot.resources import scene_files, shipped_or_path
from drake_linefoot.yaml_file import read_yaml

COURSES = ("stairs", "gaps", "stones", "blocks", "spiral", "patches")
Part = TypeVar("Part")
MOST_TILES = 2500  # already some seconds to build


@dataclass
class Scene(Parameters):
    """The ground: flat at z = 0 where the robot starts; as in `GroundParameters`, and more.

    Its shape is that of `drake_linefoot.lab.plants.ground`.
    """

    friction: Share = 0.8
    point_contact_stiffness: Stiffness = 5.0e5
    hunt_crossley_dissipation: Dissipation = 20.0
    slope: Slope = 0.0
    slope_heading: Angle = 0.0
    step_height: Height = 0.0
    tile: Edge = 0.5
    tiled: Annotated[Pair, Unit("m", 1e3)] = field(default_factory=lambda: [16.0, 8.0])
    """In x and y, around 0."""
    ledge_height: Metres = 0.0
    ledge_at: Annotated[Number, Unit("m", 1e3)] = 1.0
    stairs: StairsParameters | None = None
    gaps: GapsParameters | None = None
    stones: StonesParameters | None = None
    blocks: BlocksParameters | None = None
    spiral: SpiralParameters | None = None
    patches: Annotated[list[PatchParameters], Strict(), Len(1, MOST_PATCHES)] | None = None
    visual_size: Annotated[Triple, Unit("m", 1e3)] = field(
        default_factory=lambda: [20.0, 20.0, 0.02]
    )
    """Drawn slab; pad and slope reach as far again."""
    rgba: Annotated[list[Number], Strict(), Len(4, 4), Unit("-")] = field(
        default_factory=lambda: [0.8, 0.8, 0.8, 1.0]
    )

    @property
    def course(self) -> CourseParameters | None:
        """The course, if there is one."""
        return self.stairs or self.gaps or self.stones or self.blocks

    @together
    def _is_one(self) -> None:
        given = [name for name in COURSES if getattr(self, name)]
        if given and (self.slope or self.step_height or self.ledge_height or len(given) > 1):
            allowed = "must be none beside another course, a slope, tiles or a ledge"
            raise misfit(given[-1], "given", allowed)

    @together
    def _has_a_start(self) -> None:
        starts = [patch.height_at(0.0, 0.0) for patch in self.patches or ()]
        if starts and not any(z is not None and abs(z) < 1e-3 for z in starts):
            allowed = "must have one of height 0 where the robot starts, at 0, 0"
            raise misfit("patches", self.patches, allowed)

    @together
    def _makes_a_ground(self) -> None:
        if self.ledge_height and (self.slope or self.step_height):
            raise misfit("ledge_height", self.ledge_height, "must be 0 with a slope or tiles")
        end = self.visual_size[0]
        if not 0.0 < self.ledge_at < end:
            allowed = f"must lie between 0 and {end}, the end of the ground"
            raise misfit("ledge_at", self.ledge_at, allowed)
        tiles = (self.tiled[0] / self.tile) * (self.tiled[1] / self.tile)
        if self.step_height and tiles > MOST_TILES:
            allowed = f"gives {tiles:.0f} tiles, which must be at most {MOST_TILES}"
            raise misfit("tile", self.tile, allowed)


def load_scene(name: str, scenario: str | Path = "scenario") -> Scene:
    """Read a scene by name (of the shipped scenes) or by path.

    Raises:
        ScenarioError: there is no such scene, or it is not usable; `scenario` asks for it.
    """

    def read(file: Path) -> Scene:
        return check(read_yaml(file, "scene"), Scene, file)

    return read_part("scene", name, scene_files(), read, scenario)


def scene_of(scenario: Scenario, file: str | Path = "scenario") -> Scene:
    """Return the scene of a scenario, with the numbers that its entry `ground` gives.

    Raises:
        ScenarioError: there is no such scene, or it is not usable; `file` asks for it.
    """
    scene = load_scene(scenario.scene, file)
    given = {key: value for key, value in plain(scenario.ground).items() if value is not None}
    return check({**plain(scene), **given}, Scene, file, ["ground"])


def read_part(
    entry: str,
    name: str,
    shipped: Mapping[str, Path],
    read: Callable[[Path], Part],
    scenario: str | Path,
) -> Part:
    """Return the robot or the scene of a scenario, read from the file or folder of its name.

    Raises:
        ScenarioError: neither a shipped name nor the path of a YAML file, or not usable.
    """
    path = shipped_or_path(name, shipped)
    if path is None:
        allowed = f"unknown {entry}; must be one of {list(shipped)}, or a .yaml file"
        raise ScenarioError(scenario, entry, shown(name), allowed)
    try:
        return read(path)
    except InputError as error:
        raise ScenarioError(scenario, entry, shown(name), f"not usable: {error}") from error
