"""Speed of Bullet worlds of several sizes, and of the whole backend: `python benchmarks/pybullet_worlds.py`.

The reference is the obvious loop: one robot, one client, one process, and nothing but PyBullet's calls for the same
motor, contacts and beams. All are measured alternately in one go, and medians are compared, since the machine may be
shared.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from typing import NamedTuple

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"  # before numpy is imported; physics has the cores

import numpy as np
import pybullet
from pipenav_pybullet.backend import PybulletOptions
from pipenav_pybullet.world import Setting, World

from pipenav.backends.backend import physics_steps
from pipenav.backends.messages import Command
from pipenav.backends.simulators import open_simulator
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("basic")
PIPES = parse_corners(["working-range"])
EPISODE = 12
"""Number of control steps between two resets: the length of an episode of a trained policy."""

OPTIONS = PybulletOptions()
SETTING = Setting(OPTIONS.timestep, OPTIONS.solver_iterations, OPTIONS.contact_erp)


class Rates(NamedTuple):
    """Control steps per second of the backend, without and with its resets."""

    stepping: float
    with_resets: float


def starts(rng: np.random.Generator, n: int) -> episode.ReachEpisodes:
    """Random starts of n robots in random pipes."""
    return episode.sample(ROBOT, ReachConfig(), [PIPES[i] for i in rng.integers(0, len(PIPES), n)], rng)


def set_points(rng: np.random.Generator, n: int) -> np.ndarray:
    """Set-points ahead of a start pose, (n, 4) [m, rad], so that the robots run into their corners."""
    return rng.uniform([0.0, -0.5, -0.5, -0.5], [0.3, 0.5, 0.5, 0.5], (n, 4))


def plain_loop(episodes: int) -> float:
    """Control steps per second of one robot by PyBullet's calls alone; resets are not counted."""
    rng = np.random.default_rng(0)
    single = World(ROBOT, 1, SETTING)  # only to set the scene
    arm, joints, client = single._arms[0], single._driven, single._client
    motors = [(a.controller_gain, a.effort_limit, a.damping) for a in ROBOT.joint_actuators]
    substeps = physics_steps(OPTIONS.timestep)
    seconds = 0.0
    for _ in range(episodes):
        start = starts(rng, 1)
        single.reset([0], start.pipes, start.q, start.base)
        commands = set_points(rng, EPISODE).tolist()
        began = time.perf_counter()
        for command in commands:
            for _ in range(substeps):
                states = pybullet.getJointStates(arm, joints, physicsClientId=client)
                forces = [
                    min(max(gain * (wanted - state[0]), -limit), limit) - damping * state[1]
                    for (gain, limit, damping), wanted, state in zip(motors, command, states, strict=True)
                ]
                pybullet.setJointMotorControlArray(
                    arm, joints, pybullet.TORQUE_CONTROL, forces=forces, physicsClientId=client
                )
                pybullet.stepSimulation(physicsClientId=client)
                sum(contact[9] for contact in pybullet.getContactPoints(physicsClientId=client))
            single._configuration[0] = [state[0] for state in states]
            single._distances([0])
        seconds += time.perf_counter() - began
    single.close()
    return episodes * EPISODE / seconds


def worlds(size: int, count: int, episodes: int) -> float:
    """Control steps per second of `count` worlds of `size` robots in this process; resets are not counted."""
    rng = np.random.default_rng(0)
    all_worlds = [World(ROBOT, size, SETTING) for _ in range(count)]
    seconds = 0.0
    for _ in range(episodes):
        for one in all_worlds:
            start = starts(rng, size)
            one.reset(list(range(size)), start.pipes, start.q, start.base)
        for _ in range(EPISODE):
            values = set_points(rng, size)
            began = time.perf_counter()
            for one in all_worlds:
                one.step("position", values)
            seconds += time.perf_counter() - began
    for one in all_worlds:
        one.close()
    return episodes * EPISODE * size * count / seconds


def backend(n: int, episodes: int) -> Rates:
    """Speed of the whole backend on all cores."""
    rng = np.random.default_rng(0)
    opened = open_simulator("pybullet", ROBOT, n, OPTIONS)
    stepping = resetting = 0.0
    for _ in range(episodes):
        start = starts(rng, n)
        began = time.perf_counter()
        opened.reset(np.arange(n), start.pipes, start.q, start.base)
        resetting += time.perf_counter() - began
        for _ in range(EPISODE):
            values = set_points(rng, n)
            began = time.perf_counter()
            opened.step(Command("position", values))
            opened.read()
            opened.truth()
            stepping += time.perf_counter() - began
    opened.close()
    steps = episodes * EPISODE * n
    return Rates(steps / stepping, steps / (stepping + resetting))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    rates: dict[str, list[float]] = {}
    for _ in range(repeats):
        rates.setdefault("plain loop, one robot", []).append(plain_loop(16))
        for size in (1, 4, 8, 16, 32, 64):
            label = f"one process, 64 robots in worlds of {size}"
            rates.setdefault(label, []).append(worlds(size, 64 // size, 1))
        whole = backend(64, 2)
        rates.setdefault("backend on all cores, 64 robots", []).append(whole.stepping)
        rates.setdefault("backend on all cores, 64 robots, with resets", []).append(whole.with_resets)
    median = {label: round(statistics.median(values)) for label, values in rates.items()}
    ratio = statistics.median(rates["backend on all cores, 64 robots"]) / median["plain loop, one robot"]
    print(json.dumps({"control steps/s": median, "backend / plain loop": round(ratio, 2)}, indent=1))


if __name__ == "__main__":
    main()
