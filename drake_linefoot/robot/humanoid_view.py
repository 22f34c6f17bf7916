"""What a humanoid shows of itself: at a prompt, in a notebook, in a browser."""

from __future__ import annotations

from drake_linefoot.facts import WithFacts
from drake_linefoot.late import late
from drake_linefoot.page import HEIGHT, Page
from drake_linefoot.robot.description import HumanoidDescription


class HumanoidView(WithFacts):
    """Shows a humanoid, which has the attributes below."""

    description: HumanoidDescription
    mass: float
    com_height: float
    na: int
    half_length: float

    def show(self, height: int = HEIGHT) -> Page:
        """Show it in its nominal posture, in a cell of a notebook, in a script in a browser.

        `linefoot show` has a slider for every joint. Needs the laboratory.

        Args:
            height: in a notebook [px].

        Returns:
            The page; its `save("robot.html")` writes it.

        Raises:
            LinefootError: it cannot be drawn, or the laboratory is not installed.
        """
        page: Page = late("lab.visualization.show", "show_robot")(self, height)
        return page

    def _title(self) -> str:
        return f"Humanoid {self.description.name!r}"

    def _facts(self) -> dict[str, object]:
        length = 2.0 * self.half_length
        return {
            "size": f"{self.mass:.2f} kg, CoM {self.com_height:.3f} m high, {self.na} motors",
            "feet": f"{self.description.contact} contact, {1e3 * length:.0f} mm",
            "model": self.description.model,
            "look": "humanoid.show(), humanoid.plant, humanoid.description",
        }
