"""Take-overs from a policy and hand-backs at random moments: how far commands jump, and how much their speed does.

    python benchmarks/take_overs.py --policy arm --moments 1000
    python benchmarks/take_overs.py --policy pirate-strong --moments 1000
    python benchmarks/take_overs.py --policy pirate-strong --pipes runs-rolled --roll     # in space, the roll joint too

A hand takes over at random moments, moves something at random for up to 1.1 s and lets go. What was commanded is read
from the telemetry. Exits with 1 if a command jumped by more than a step's limit, or a joint's commanded speed by more
than its limit when the driver changed or while the hand drove.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))

from helpers.driving import RandomHands, changes

from pipenav.driving.plans import make_plan
from pipenav.driving.sessions import Session

ROUNDING = 1e-6


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policy", default="arm")
    parser.add_argument("--moments", type=int, default=1000, help="least number of take-overs")
    parser.add_argument("--pipes", nargs="+", default=["working-range"])
    parser.add_argument("--roll", action="store_true", help="turn the roll joint too, in space")
    given = parser.parse_args()
    took = gave = passed = episodes = 0
    jump = broken = 0.0
    for seed in itertools.count():
        with tempfile.TemporaryDirectory() as folder:
            plan = make_plan(given.policy, None, given.pipes, 1, seed).on("mujoco", {}, None, Path(folder))
            session = Session(plan, lambda i, plan=plan: RandomHands(plan.robot, i, roll=given.roll))  # type: ignore[misc]
            session.run()
            found = [changes(path, plan.robot) for path in Path(folder).glob("*.jsonl")]
        took += sum(one.count[0] for one in found)
        gave += sum(one.count[1] for one in found)
        jump, broken = max(jump, *(one.jump for one in found)), max(broken, *(one.break_ for one in found))
        passed, episodes = passed + sum(one.passed for one in session.records), episodes + len(found)
        print(
            f"{given.policy}: {took} take-overs, {gave} hand-backs in {episodes} episodes, {passed} passed; largest "
            f"jump {jump:.3f} of a step's limit, largest change of a joint's speed {broken:.3f} of its limit",
            flush=True,
        )
        if took >= given.moments:
            return int(max(jump, broken) > 1 + ROUNDING)
    return 0


if __name__ == "__main__":
    sys.exit(main())
