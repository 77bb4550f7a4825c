"""Routes of all sizes in one batch: models grow when a larger route comes, and robots go on where they are."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from pipenav.backends.simulators import open_space
from pipenav.pipes.reducer import reducer
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import load_robot
from pipenav.testing import SpaceBench, space_starts
from pipenav.testing.laws import require_same
from pipenav.testing.space_laws import space_state

ROBOT = load_robot("pirate-strong")
SMALL = PipeRoute.of(90, [(120, "left", 0)], [1500, 900])
LARGE = [
    PipeRoute.of(110, [(55, "left", 30), (60, "right", 90), (90, "left", 90, 150)], [1500, 900, 900, 800]),
    reducer(100, 80, 60, 1500),
]


def test_robots_go_on_where_they_are_when_models_grow() -> None:
    bench = SpaceBench("mujoco", n=3)
    start = space_starts(bench)._replace(routes=[SMALL] * 3)
    with bench.open() as grown, bench.open() as unchanged:
        for subject in (grown, unchanged):
            start.begin(subject)
        for i, (set_points, roll) in enumerate(bench.commands(8)):
            if i == 3:
                larger = start._replace(routes=[SMALL, *LARGE]).part(np.arange(1, 3))
                larger.begin(grown)
            for subject in (grown, unchanged):
                subject.step(set_points, roll)
            one, other = ({name: v[:1] for name, v in space_state(s).items()} for s in (grown, unchanged))
            require_same(one, other, "a robot whose neighbours got larger routes and the same robot alone")


def test_a_robot_without_a_route_waits_out_of_the_way() -> None:
    start = space_starts(SpaceBench("mujoco", n=1))
    with closing(open_space("mujoco", ROBOT, 2, {})) as backend:
        start.begin(backend)
        backend.step(np.zeros((2, len(ROBOT.driven_actuators))), np.zeros(2))
        truth = backend.truth()
        assert truth.penetration[1] == 0.0 and truth.contact_force[1] == 0.0
        start._replace(indices=np.array([1])).begin(backend)
        np.testing.assert_allclose(backend.read().body.time, [0.1, 0.0])
