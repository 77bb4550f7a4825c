"""The pilot of robots in space: many at once decide as each would alone."""

from __future__ import annotations

import numpy as np
from helpers.rolling import ROBOT, clamped

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.backends.spatial import SpaceReading
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.tasks.rolling.manoeuvre import RollPhase
from pipenav.tasks.rolling.pilot import Mode, Pilot

STEPS, SPELL = 500, 25
"""Control steps, and for how many of them a made-up robot goes on doing the same."""

ROBOTS = 16
ROUTES = parse_routes(["runs-rolled", "runs-level"])


def readings(routes: list[PipeRoute], rng: np.random.Generator) -> list[SpaceReading]:
    """Made-up readings of robots that clamp, wriggle or stand still for a while, turn, and see ends of straights."""
    n, beams, made = len(routes), ROBOT.laser.beams, []
    sides = rng.choice([-1.0, 1.0], n)
    pose = np.array([clamped(route.radius, side) for route, side in zip(routes, sides, strict=True)])
    for step in range(STEPS):
        if step % SPELL == 0:
            loose, moves = rng.random((2, n, 1)) < 0.5
            ahead, heavy = rng.choice([0.02, 0.02, 0.5], (n, 1)), rng.random((n, 1, 1)) < 0.5
        q = pose + np.where(loose & moves, 0.6, 0.02) * rng.normal(size=(n, 6))
        speeds = np.where(moves, 4.0, 0.0) * rng.normal(1.0, 0.3, (n, 6)) * -np.sign(q)
        turned = rng.normal(0.01, 0.2, (n, 2, 3)) * np.array([0.02, 1.0, 1.0])
        down = np.where(heavy, rng.normal(size=(n, 2, 3)), 0.0)
        body = Reading(q, np.zeros((n, 6)), ahead * rng.random((n, beams)), np.zeros(n), speeds, np.zeros((n, 12)))
        made.append(SpaceReading(body, 0.05 * rng.normal(size=n), down, turned))
    return made


def part(reading: SpaceReading, indices: Ints) -> SpaceReading:
    body = reading.body.part(indices)
    return SpaceReading(body, *(column[indices] for column in reading[1:]))


def drive(routes: list[PipeRoute], seen: list[SpaceReading], wanted: Floats) -> tuple[Floats, set[int], set[str]]:
    """Commands of every step, (steps, n, 13), and the modes and phases that occurred."""
    pilot, rows = Pilot(ROBOT, len(routes)), np.arange(len(routes))
    pilot.start(rows, routes, np.zeros((len(routes), 6)))
    commands, modes, phases = [], set[int](), set[str]()
    for reading in seen:
        values, roll = pilot.command(reading, wanted)
        commands.append(np.concatenate([values, roll[:, None]], axis=1))
        pilot.sense(reading)
        modes |= set(pilot.mode.tolist())
        phases |= {words for words in pilot.doing if words.startswith("rolling: ")}
    return np.array(commands), modes, phases


def test_robots_together_are_driven_as_each_would_be_alone() -> None:
    all_modes, all_phases = set[int](), set[str]()
    for seed in range(3):
        rng = np.random.default_rng(seed)
        routes = [ROUTES[i] for i in rng.permutation(len(ROUTES))[:ROBOTS]]
        seen, wanted = readings(routes, rng), rng.normal(size=(ROBOTS, 12))
        together, modes, phases = drive(routes, seen, wanted)
        all_modes, all_phases = all_modes | modes, all_phases | phases
        for i in range(0, ROBOTS, 5):
            alone, _, _ = drive([routes[i]], [part(reading, np.array([i])) for reading in seen], wanted[i : i + 1])
            np.testing.assert_array_equal(alone[:, 0], together[:, i])
    assert all_modes == {mode.value for mode in Mode}
    assert len(all_phases) >= len(RollPhase) - 2
