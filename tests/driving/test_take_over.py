"""Taking over from a policy and handing back, at random moments: no command jumps, and no speed does."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.driving import RandomHands, changes

from pipenav.driving.plans import make_plan
from pipenav.driving.sessions import Session

ROUNDING = 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["arm", "pirate-strong"])
def test_neither_a_take_over_nor_a_hand_back_jumps_in_position_or_speed(policy: str, tmp_path: Path) -> None:
    plan = make_plan(policy, None, ["d=100,angle=90", "d=90,angle=75,turn=right"], 6, 0)
    plan = plan.on("mujoco", {}, None, tmp_path)
    session = Session(plan, lambda i: RandomHands(plan.robot, i))
    session.run()
    found = [changes(path, plan.robot) for path in sorted(tmp_path.glob("*.jsonl"))]
    assert len(found) == plan.total
    assert sum(one.count[0] for one in found) == sum(record.takeovers for record in session.records) > 10
    assert max(one.jump for one in found) <= 1 + ROUNDING
    assert max(one.break_ for one in found) <= 1 + ROUNDING


def test_pipes_are_numbered_by_the_seed_alone() -> None:
    """The episodes of one driver are those of another, whoever drives and however many."""
    from pipenav.evaluation.episode_runner import random_start

    starts = []
    for policy in (None, "pirate-strong", "baseline:sequence"):
        robot = None if policy == "pirate-strong" else "pirate-strong"
        plan = make_plan(policy, robot, ["d=90,angle=75"], 3, 5)
        start = random_start(plan.robot, plan.lengthened, plan.pipes, plan.episodes, plan.seed)
        starts.append([start(i) for i in range(3)])
    for others in starts[1:]:
        for one, other in zip(starts[0], others, strict=True):
            assert (one.q == other.q).all()
            assert (one.base == other.base).all()
