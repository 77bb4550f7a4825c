"""Pictures of two simulators side by side, in millimetres, degrees and newtons."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.comparison.agreement import Agreement, SimulatorPair, tip_distance
from pipenav.comparison.trials import CORNERS
from pipenav.drawing.style import GRID, INK, MAIN, MUTED, SECOND
from pipenav.robots.robot import RobotSpec
from pipenav.units import rad_to_deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

REFERENCE: dict[str, Any] = {"color": MAIN, "lw": 3.2, "alpha": 0.45}
OTHER: dict[str, Any] = {"color": SECOND, "lw": 1.2}
"""Styles of the curves: the reference is broad and pale, the other narrow on top of it, so that both are seen."""


def free_motion_figure(robot: RobotSpec, agreement: Agreement, names: tuple[str, str]) -> Figure:
    """Motion of each joint under a pulse of duty and a step of its set-point, and the differences below."""
    joints = robot.joints
    figure = _figure(3.0 * len(joints), 7.2)
    rows = figure.subplots(3, len(joints), sharex=True)
    for j, joint in enumerate(joints):
        factor, unit = (rad_to_deg(1.0), "deg") if joint.type == "hinge" else (1e3, "mm")
        for row, (what, sides) in enumerate((("pulse of duty", agreement.driven), ("step", agreement.stepped))):
            axes = rows[row, j]
            _curves(axes, SimulatorPair(*(factor * side[j, :, j] for side in sides)), names)
            axes.set_ylabel(f"{joint.name} [{unit}]")
            axes.set_title(f"{joint.name}, {what}", fontsize=10, color=INK)
        axes = rows[2, j]
        for label, sides in (("pulse", agreement.driven), ("step", agreement.stepped)):
            difference = factor * (sides.other - sides.reference)[j, :, j]
            axes.plot(_times(len(difference)), np.append(0.0, difference), label=label, lw=1.4)
        axes.axhline(0.0, color=MUTED, lw=0.8)
        axes.set(ylabel=f"difference [{unit}]", xlabel="time [s]")
        _plain(axes)
    rows[0, 0].legend(frameon=False, fontsize=9)
    rows[2, 0].legend(frameon=False, fontsize=9)
    figure.suptitle(f"Free motion of each joint of {robot.name}: {names[1]} against {names[0]}", color=INK)
    return figure


def passages_figure(robot: RobotSpec, agreement: Agreement, names: tuple[str, str]) -> Figure:
    """Paths of the tip on the same open-loop passages, and the distance between the two tips."""
    figure = _figure(3.2 * len(CORNERS), 6.4)
    rows = figure.subplots(2, len(CORNERS), height_ratios=[2, 1])
    apart = 1e3 * tip_distance(agreement)
    for i, pipe in enumerate(CORNERS):
        axes = rows[0, i]
        for wall in pipe.walls:
            axes.plot(*(1e3 * wall).T, color=INK, lw=1.2)
        for side, style, name in zip(agreement.tips, (REFERENCE, OTHER), names, strict=True):
            axes.plot(*(1e3 * side[i]).T, label=name, **style)
        tips = 1e3 * agreement.tips.reference[i]
        low, high = np.nanmin(tips, axis=0) - 60, np.nanmax(tips, axis=0) + 60
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [mm]")
        axes.set_title(pipe.name, fontsize=10, color=INK)
        _plain(axes)
        below = rows[1, i]
        below.plot(_times(apart.shape[1])[1:], apart[i], color=SECOND, lw=1.4)
        below.set(ylim=(0.0, 1.15 * np.nanmax(apart) or 1.0), xlabel="time [s]")
        _plain(below)
    rows[0, 0].set_ylabel("y [mm]")
    rows[1, 0].set_ylabel("tips apart [mm]")
    rows[0, 0].legend(frameon=False, fontsize=9)
    figure.suptitle(f"The same set-points through four corners, {robot.name}: {names[1]} against {names[0]}", color=INK)
    return figure


def walls_figure(robot: RobotSpec, agreement: Agreement, names: tuple[str, str]) -> Figure:
    """Contact force while each joint in turn presses on a wall."""
    figure = _figure(3.0 * len(robot.joints), 3.6)
    for j, (joint, axes) in enumerate(zip(robot.joints, np.ravel(figure.subplots(1, len(robot.joints))), strict=True)):
        _curves(axes, SimulatorPair(*(side[j] for side in agreement.force)), names)
        axes.set(xlabel="time [s]", ylim=(0.0, None))
        axes.set_title(f"{joint.name} presses", fontsize=10, color=INK)
        if j == 0:
            axes.set_ylabel("contact force [N]")
            axes.legend(frameon=False, fontsize=9)
    figure.suptitle(
        f"Contact of {robot.name} without friction, peaks over a control step: {names[1]} against {names[0]}", color=INK
    )
    return figure


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure((width, height), facecolor="white", layout="constrained")


def _curves(axes: Axes, sides: SimulatorPair, names: tuple[str, str]) -> None:
    for side, style, name in zip(sides, (REFERENCE, OTHER), names, strict=True):
        axes.plot(_times(len(side)), np.append(0.0, side), label=name, **style)
    _plain(axes)


def _times(steps: int) -> Floats:
    """Times at the start of the first control step and at the end of each [s]."""
    return np.asarray(CONTROL_PERIOD * np.arange(steps + 1))


def _plain(axes: Axes) -> None:
    axes.grid(color=GRID, lw=0.8)
    axes.set_axisbelow(True)
    for edge in ("top", "right"):
        axes.spines[edge].set_visible(False)
    axes.tick_params(colors=MUTED, labelsize=8)
