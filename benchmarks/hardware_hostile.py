"""Goals that reach the servos when the policy is mad, judged by the bytes that arrived.

    python benchmarks/hardware_hostile.py                      # 100,000 actions: about 6 minutes
    python benchmarks/hardware_hostile.py --actions 2000 --seed 7

Actions are random of every size, on and beyond every limit, and nonsense: not a number, infinite, text, None, lists,
too many or too few. They pass the driver's own limits and bus to an emulated arm, as fast as that answers, so that the
arm is anywhere between its limits when the next one comes. Exits with 1 if a goal was outside its limits, farther from
the last goal than a step, or farther from where the servo had said it is than a step and the slack, or if a moving
speed was 0 or above its limit.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pipenav_hardware.beam_filter import BeamFilter
from pipenav_hardware.codec import STEP_SLACK, Codec, Raw
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings
from pipenav_hardware.ranging import RangeScan
from pipenav_hardware.servos import Servos

from pipenav.backends.messages import Command
from pipenav.backends.safety import Stopped
from pipenav.robots.robot import load_robot

ROBOT = load_robot("real-setup")
NONSENSE: list[Any] = [
    np.nan,
    np.inf,
    -np.inf,
    1e308,
    -1e308,
    1e400,
    "left",
    "",
    None,
    [1.0],
    {},
    b"\x00",
    1 + 2j,
    True,
]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--actions", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    with Emulator(ROBOT, EmulatorSettings(front_sensor=False, adapter_latency=0.0)) as emulator:
        bus = Bus(emulator.arm.port, emulator.arm.baud)
        codec = Codec(ROBOT, emulator.arm, BeamFilter(ROBOT.laser, ROBOT.laser.angles, 0.1, 0.5))
        stops = attack(Servos(emulator.arm, bus), codec, given.actions, rng)
        bus.off(emulator.arm.ids)
        bus.close()
        goals, wrong = arrived(emulator.log_path, codec)
    print(f"{given.actions} actions, {stops} of them stopped the arm, {goals} goals arrived, {wrong} of them wrong")
    return int(wrong > 0 or not goals)


def attack(servos: Servos, codec: Codec, actions: int, rng: np.random.Generator) -> int:
    """Have the driver send that many actions, going on after every stop.

    Returns:
        The number of actions that it answered with a stop.
    """
    scan = RangeScan((300,) * ROBOT.laser.beams, 0.0, 1)
    codec.last = np.array(servos.enable(codec.speeds, lambda: None), float)
    stops = 0
    for _ in range(actions):
        try:
            if codec.decode(Raw(servos.read().states, scan, None, 0.0)) is not None:
                encoded = codec.encode(Command("position", action(rng)))
                if encoded.goals:
                    servos.send_goals(encoded.goals)
        except Stopped:
            stops += 1
    return stops


def action(rng: np.random.Generator) -> Any:
    """An action: mostly numbers, of any size; sometimes nonsense."""
    joints = len(ROBOT.joints)
    kind = rng.integers(8)
    if kind == 0:
        values: list[Any] = list(rng.uniform(ROBOT.lower, ROBOT.upper))
        values[rng.integers(joints)] = NONSENSE[rng.integers(len(NONSENSE))]
        return np.array([values], object)
    if kind == 1:
        return rng.uniform(-1, 1, int(rng.integers(0, 9)))
    if kind == 2:
        return NONSENSE[rng.integers(len(NONSENSE))]
    if kind == 3:
        return rng.choice(np.stack([ROBOT.lower, ROBOT.upper]))[None] * (1 + 1e-3 * rng.normal(size=joints))
    return (rng.normal(size=joints) * 10.0 ** rng.uniform(-4, 300 if kind == 4 else 2))[None]


class Arrived(NamedTuple):
    """Number of goals that arrived, and of those among them that should not have."""

    goals: int
    wrong: int


def arrived(log: Path, codec: Codec) -> Arrived:
    """The goals that reached the servos."""
    bounds, speeds = codec.bounds, codec.speeds
    goals = wrong = 0
    for goal in byte_log.goals(log):
        i = goal.servo - 1
        step = bounds.step[i]
        inside = bounds.lower[i] <= goal.goal <= bounds.upper[i]
        near = goal.last is None or abs(goal.goal - goal.last) <= step
        reachable = goal.present is not None and abs(goal.goal - goal.present) <= step + STEP_SLACK
        slow = goal.speed is None or 1 <= goal.speed <= speeds[i]
        goals += 1
        wrong += not (inside and near and reachable and slow)
    return Arrived(goals, wrong)


if __name__ == "__main__":
    sys.exit(main())
