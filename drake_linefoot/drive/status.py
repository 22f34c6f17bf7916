"""What is said on screen during a drive."""

from collections.abc import Iterable

import numpy as np

from drake_linefoot.drive.pace import Pace
from drake_linefoot.drive.session import Session
from drake_linefoot.drive.teleop import Orders
from drake_linefoot.simulation.channels import FEET
from drake_linefoot.simulation.run import recent_velocity

MODELS = {"ecd": "ECD", "srbm": "single rigid body"}


def status(session: Session, orders: Orders, pace: Pace, remark: str = "") -> list[str]:
    """Return short lines: rate, speeds, contact, solvers, push, and a fall with its reason.

    Args:
        session: what is simulated.
        orders: in force.
        pace: its rate.
        remark: anything else; empty for nothing.
    """
    lines = [
        f"{session.time:.1f} s, {_rate(session, orders, pace)}",
        f"asked:  {_velocity(orders.command[:3])}",
        f"walks:  {_velocity(recent_velocity(session.loop.recorder))}",
        f"on ground: {_contact(session)}",
        f"{MODELS[session.tuning.model]}: {_solver(session)}",
        f"aim of P: {orders.aim}",
    ]
    if remark:
        lines.append(remark)
    if session.fall:
        lines += ["The robot FELL. R: begin again", session.fall]
    return lines


def _rate(session: Session, orders: Orders, pace: Pace) -> str:
    if session.fall:
        return "fallen"
    if orders.paused:
        return "paused"
    return f"{pace.rate:.2f} x real time{'' if pace.keeps_up else ', too slow'}"


def _velocity(velocity: Iterable[float]) -> str:
    return "  ".join(f"{value + 0.0:.2f}" for value in velocity)


def _contact(session: Session) -> str:
    flags = session.last("contact_flag")
    return " ".join(foot for foot, flag in zip(FEET, flags, strict=True) if flag > 0.5) or "none"


def _solver(session: Session) -> str:
    """Return whether MPC and whole-body controller are solved now, and failures so far."""
    mpc, wbc = session.last("mpc_success"), session.last("wbc_success")
    failures = np.nan_to_num(session.last("mpc_failures"))
    names = [name for name, flag in (("MPC", mpc), ("WBC", wbc)) if flag < 0.5]
    said = f"{', '.join(names)} NOT solved" if names else "solved"
    return f"{said}, {int(failures)} failed"
