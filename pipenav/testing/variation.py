"""Laws of a simulator whose robots can differ from their description (`Simulator.can_vary`).

They hold trivially for a backend whose robots cannot.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Backend, Variation
from pipenav.backends.messages import Command
from pipenav.pipes.corner import PipeCorner
from pipenav.testing.bench import Bench, starts
from pipenav.testing.laws import Law, can_vary, require, state_of

WEAKER = 0.8
"""Factor whose effect is too large to be missed."""


def check_variation_of_one_changes_nothing(bench: Bench) -> None:
    """Factors of 1 leave every bit as it was, also after other factors."""
    with bench.open() as varied, bench.open() as plain:
        if not can_vary(varied):
            return
        indices = np.arange(bench.n)
        varied.vary(indices, factors(bench, friction=2.0, mass=WEAKER, strength=WEAKER, gain=WEAKER))
        start = starts(bench, seed=1)
        # Values that a simulator derives from these small walls must not outlive them.
        small = [PipeCorner.of(60, 150, leg_mm=150)] * bench.n
        varied.reset(indices, small, start.q, start.base - 0.5)
        for command in bench.commands(3):
            varied.step(command)
        varied.vary(indices, factors(bench))
        _require_same(_driven(bench, varied), _driven(bench, plain), indices)


def check_variation_touches_only_named_robots(bench: Bench) -> None:
    """Robots that a variation does not name go on exactly as if nothing had happened."""
    with bench.open() as varied, bench.open() as plain:
        if not can_vary(varied):
            return
        chosen, others = np.arange(1, bench.n, 2), np.arange(0, bench.n, 2)
        changed = factors(bench, friction=0.0, mass=2.0, strength=WEAKER, gain=WEAKER)
        varied.vary(chosen, changed.part(chosen))
        _require_same(_driven(bench, varied), _driven(bench, plain), others)


def check_weak_actuators_push_less(bench: Bench) -> None:
    """A slide presses head-on on a wall with its effort limit times its strength."""
    robot = bench.robot
    with bench.open() as subject:
        if not can_vary(subject) or robot.link_turns[0]:
            return
        strength = np.linspace(WEAKER, 1.0 / WEAKER, bench.n)
        changed = factors(bench)
        changed.strength[:] = strength[:, None]
        subject.vary(np.arange(bench.n), changed)
        pipe, q = PipeCorner.of(120, 90), np.zeros((bench.n, len(robot.joints)))
        base = np.full(bench.n, pipe.radius - 0.01 - robot.length)
        subject.reset(np.arange(bench.n), [pipe] * bench.n, q, base)
        duties = np.zeros_like(q)
        duties[:, 0] = 1.0
        for _ in range(30):
            subject.step(Command("torque", duties))
        pushed = subject.truth().contact_force
        expected = strength * robot.effort_limits[0]
        np.testing.assert_allclose(pushed, expected, rtol=0.02, err_msg="force of a slide on a wall")


def check_each_factor_acts_the_right_way(bench: Bench) -> None:
    """Heavy or weak joints start more slowly than those of an unchanged robot, and soft controllers lag behind."""
    robot, n = bench.robot, bench.n
    wide = PipeCorner.of(300, 180)
    joints, wheels = 0.2 * np.where(robot.hinges, robot.upper, 0.1), np.zeros(len(robot.wheels))
    ahead, straight = np.tile(np.concatenate([joints, wheels]), (n, 1)), np.zeros((n, robot.coordinates))
    trials: list[tuple[dict[str, float], Command]] = [
        ({"mass": 2.0}, Command("torque", np.ones_like(ahead))),
        ({"strength": WEAKER}, Command("torque", np.ones_like(ahead))),
        ({"strength": WEAKER}, Command("position", ahead)),
        ({"gain": 0.2}, Command("position", 0.1 * ahead)),
    ]
    for changed, command in trials:
        positions = []
        for factor in (changed, {}):
            with bench.open() as subject:
                if not can_vary(subject):
                    return
                subject.vary(np.arange(n), factors(bench, **factor))
                subject.reset(np.arange(n), [wide] * n, straight, np.full(n, -robot.length))
                subject.step(command)
                positions.append(subject.read().q[:, 0])
        one, other = positions
        require(bool(np.all(one < other)), f"a first joint with {changed} moves to {one}, an unchanged one to {other}")


def check_friction_holds_what_slides(bench: Bench) -> None:
    """An arm that presses sideways on a wall is pulled along it more slowly the rougher it is."""
    robot, n = bench.robot, bench.n
    with bench.open() as subject:
        if not can_vary(subject) or robot.link_turns[0] or len(robot.joints) < 2:
            return
        changed = factors(bench)
        changed.friction[:] = np.linspace(0.0, 3.0, n)
        subject.vary(np.arange(n), changed)
        pipe = PipeCorner.of(100, 180)
        subject.reset(np.arange(n), [pipe] * n, np.zeros((n, len(robot.joints))), np.full(n, -robot.length))
        duties = np.zeros((n, len(robot.joints)))
        duties[:, 1] = 1.0
        for _ in range(10):
            subject.step(Command("torque", duties))
        before = subject.read().q[:, 0]
        duties[:, 0] = -0.2
        for _ in range(3):
            subject.step(Command("torque", duties))
        slid = before - subject.read().q[:, 0]
    fell = bool(np.all(np.diff(slid) < 0))
    require(fell, f"arms slide by {slid} m: with friction of 0 to 3 times the robot's it should be less and less")


VARIATION_LAWS: list[Law] = [
    check_variation_of_one_changes_nothing,
    check_variation_touches_only_named_robots,
    check_weak_actuators_push_less,
    check_each_factor_acts_the_right_way,
    check_friction_holds_what_slides,
]
"""Laws of simulators that can vary their robots."""


def factors(bench: Bench, **given: float) -> Variation:
    """Variation with the same factors for all actuators and robots; 1 where none is given."""
    n, actuators = bench.n, len(bench.robot.driven_actuators)
    shapes = {"friction": (n,), "mass": (n, len(bench.robot.links)), "strength": (n, actuators), "gain": (n, actuators)}
    return Variation(**{name: np.full(shape, given.get(name, 1.0)) for name, shape in shapes.items()})


def _driven(bench: Bench, subject: Backend) -> list[Floats]:
    """All that a backend reports while it executes commands of both kinds from the start."""
    subject.reset(*starts(bench))
    reported: list[Floats] = []
    for command in [*bench.commands(8), *bench.commands(4, "position")]:
        subject.step(command)
        reported += state_of(subject).values()
    return reported


def _require_same(one: list[Floats], other: list[Floats], indices: Ints) -> None:
    """Require what was reported of some robots to be equal to the last bit."""
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a[indices], b[indices], err_msg="robots that were not varied")
