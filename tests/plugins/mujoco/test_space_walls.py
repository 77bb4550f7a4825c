"""Walls in space against mechanics: seams, and a ball in a round bore."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from pipenav_mujoco.model import ROBOT_TOUCHES, Contact, new_spec, surface
from pipenav_mujoco.space_walls import Layout, add_walls

from pipenav.arrays import Floats
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.solid_walls import SECTION
from pipenav.robots.robot import load_robot

ROBOT = load_robot("pirate-strong")
CONTACT = Contact(0.005, (0.95, 0.99, 0.001))
BALL, DIAMETER, FRICTION, G = 0.012, 100.0, 0.6, 9.81
SLIPPERY = ROBOT.model_copy(update={"friction": 0.0})


def straight(legs: tuple[float, ...] = (1500.0, 1500.0)) -> PipeRoute:
    """A straight pipe along x of several legs [mm], with seams between them."""
    return PipeRoute.of(DIAMETER, [(180, "left", 0)] * (len(legs) - 1), legs)


def ball_in(route: PipeRoute, friction: float, tilt: float = 0.0, turns: bool = True) -> tuple[Any, Any]:
    """A free ball in a route that falls by an angle, whose walls have no friction of their own: model and data."""
    spec = new_spec(SLIPPERY, 0.001)
    spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
    spec.option.gravity = [G * math.sin(tilt), 0.0, -G * math.cos(tilt)]
    inertia = [1e-5 if turns else 1.0] * 3
    body = spec.worldbody.add_body(
        name="ball", explicitinertial=True, mass=0.1, inertia=inertia, ipos=[0.0] * 3, iquat=[1.0, 0.0, 0.0, 0.0]
    )
    body.add_freejoint()
    sphere, of_ball = mujoco.mjtGeom.mjGEOM_SPHERE, surface(friction, CONTACT)
    body.add_geom(type=sphere, size=[BALL, 0, 0], **ROBOT_TOUCHES, **of_ball)
    add_walls(spec, SLIPPERY, route, CONTACT, Layout.of(route))
    model = spec.compile()
    return model, mujoco.MjData(model)


def run(model: Any, data: Any, seconds: float) -> Floats:
    """Positions of the ball at every step, (steps, 3)."""
    places = []
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        places.append(data.qpos[:3].copy())
    return np.array(places)


def test_a_ball_swings_across_the_bore_with_the_period_of_a_pendulum_that_slides() -> None:
    """Without friction it is a pendulum as long as the bore's radius less its own: 2 pi sqrt(L / g) at small angles."""
    model, data = ball_in(straight(), 0.0)
    length, angle = DIAMETER / 2000 - BALL, math.radians(40)
    data.qpos[:3] = -0.5, length * math.sin(angle), -length * math.cos(angle) + 2e-4
    across = run(model, data, 3.0)[:, 1]
    crossings = np.flatnonzero((across[:-1] > 0) & (across[1:] <= 0))
    period = np.diff(crossings).mean() * model.opt.timestep
    exact = 2 * math.pi * math.sqrt(length / G) * (1 + angle**2 / 16 + 11 * angle**4 / 3072)
    assert period == pytest.approx(exact, rel=0.03)
    assert np.abs(across).max() <= length * math.sin(angle) * 1.02


def test_a_ball_rests_as_deep_as_its_weight_presses_it_into_the_bore() -> None:
    model, data = ball_in(straight(), FRICTION)
    r = DIAMETER / 2000
    data.qpos[:3] = -0.5, 0.0, -(r - BALL)
    run(model, data, 1.0)
    lowest = r / math.cos(math.pi / SECTION.sides) * (1 - SECTION.inside)
    assert -lowest - 1e-4 < data.qpos[2] - BALL < -r * (1 - SECTION.inside) + 1e-4


@pytest.mark.parametrize("slope", [0.5, 1.5])
def test_a_ball_that_cannot_turn_holds_on_a_slope_up_to_the_cone_of_friction(slope: float) -> None:
    tilt = math.atan(slope * FRICTION)
    model, data = ball_in(straight(), FRICTION, tilt, turns=False)
    data.qpos[:3] = -0.8, 0.0, -(DIAMETER / 2000 - BALL)
    run(model, data, 0.2)
    before, speed = data.qpos[0], data.qvel[0]
    run(model, data, 0.3)
    wedged = FRICTION / math.cos(math.pi / SECTION.sides)  # two sides press on it, each aslant
    pull = G * (math.sin(tilt) - wedged * math.cos(tilt))
    gone = speed * 0.3 + max(pull, 0.0) * 0.3**2 / 2
    assert data.qpos[0] - before == pytest.approx(gone, rel=0.06, abs=0.002)


@pytest.mark.parametrize("friction", [0.0, FRICTION])
def test_a_ball_rolls_over_seams_as_over_a_wall_without_any(friction: float) -> None:
    ends = []
    for route in (straight((1500.0, 1500.0)), straight((1300.0, 200.0, 150.0, 150.0, 1200.0))):
        model, data = ball_in(route, friction)
        start = -route.straights[0]
        data.qpos[:3] = start + 0.9, 0.004, -(DIAMETER / 2000 - BALL)
        data.qvel[:3] = 0.5, 0.02, 0.0
        ends.append(run(model, data, 2.0) - [start, 0, 0])
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-3)
    assert ends[1][-1, 0] > 1.4  # behind all seams
