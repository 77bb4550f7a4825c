"""Commands that are killed at random moments: `python tests/fuzz/kills.py --kills 200`.

After every kill, what lay there before is whole, what was saved can be opened, no process of the command is left five
seconds later, and of a training at most the last ten seconds are lost.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import NamedTuple

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [] if str(TESTS) in sys.path else [str(TESTS)]

from helpers.processes import started  # noqa: E402

from pipenav.errors import PipenavError  # noqa: E402
from pipenav.evaluation.report import FILES  # noqa: E402
from pipenav.evaluation.results import read_evaluation  # noqa: E402
from pipenav.export.corner_folder import FILES as PIPE_FILES  # noqa: E402
from pipenav.export.corner_folder import read_pipe  # noqa: E402
from pipenav.learning.training_folder import TrainingFolder  # noqa: E402
from pipenav.policies.policy import load_policy  # noqa: E402

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)

GONE_S, LOST_S = 5.0, 10.0
"""Times in which all processes of a killed command are gone, and from a training's last saving to its kill [s]."""

SLACK_S = 2.0
"""Time that a saving may be late: it waits for the end of an update [s]."""

SMALL = ("--pipes", "d=100,angle=90", "--set=check.every=20000", "--set=check.episodes=20")


class Victim(NamedTuple):
    """A command that is killed.

    Attributes:
        words: the command, in a folder of its own.
        latest: latest moment of a kill after its start [s].
        earlier: whether it first ends undisturbed, so that earlier results lie there.
        problems: what is wrong in the folder, given the time of the kill.
    """

    words: tuple[str, ...]
    latest: float
    earlier: bool
    problems: Callable[[Path, float], Iterator[str]]


def pipe_problems(folder: Path, _killed: float) -> Iterator[str]:
    read_pipe(pipe := folder / "corner-d100-a75-left")
    yield from _gone(pipe, PIPE_FILES)


def evaluation_problems(folder: Path, _killed: float) -> Iterator[str]:
    read_evaluation(folder / "measured")
    yield from _gone(folder / "measured", FILES)


def _gone(folder: Path, names: Collection[str]) -> Iterator[str]:
    if missing := set(names) - {path.name for path in folder.iterdir()}:
        yield f"{', '.join(sorted(missing))} gone from {folder.name}"


def training_problems(folder: Path, killed: float) -> Iterator[str]:
    for config in folder.rglob("config.json"):
        training = TrainingFolder(config.parent)
        began = training.checkpoint if training.checkpoint.exists() else config
        if killed - began.stat().st_mtime > LOST_S + SLACK_S:
            yield f"{killed - began.stat().st_mtime:.1f} s are lost"
        if training.checkpoint.exists():
            TrainingFolder.open(config.parent)
            load_policy(training.last)
        for policy in (training.best, training.last):
            if policy.exists():
                load_policy(policy)


def experiment_problems(folder: Path, _killed: float) -> Iterator[str]:
    """An experiment's trainings may have ended long ago: what is there must open."""
    yield from training_problems(folder, 0.0)
    for evaluation in folder.rglob("eval.json"):
        read_evaluation(evaluation.parent)


VICTIMS = {
    "gen-pipe": Victim(("gen-pipe", "--d", "100", "--angle", "75", "--out", "."), 1.5, True, pipe_problems),
    "eval": Victim(
        ("eval", "--policy", "arm", "--pipes", "d=100,angle=90", "--episodes", "10", "--out", "measured"),
        2.5,
        True,
        evaluation_problems,
    ),
    "train": Victim(("train", "--steps", "10000000", *SMALL, "--out", "trained"), 15.0, False, training_problems),
    "experiment": Victim(
        ("experiment", "f", "--seeds", "2", "--steps", "5000", "--episodes", "2", "--jobs", "2", "--out", "tried"),
        20.0,
        False,
        experiment_problems,
    ),
}


def kill(victim: Victim, number: int, after: float) -> list[str]:
    """Faults after a command was killed by a signal, some time after its start [s]."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if victim.earlier:
            _whole(victim, folder)
        with started(*victim.words, folder=folder) as family:
            time.sleep(after)
            killed = time.time()
            if number == signal.SIGINT:
                os.killpg(family.command.pid, number)  # as a terminal does
            elif family.command.poll() is None:
                os.kill(family.command.pid, number)
            said, _ = family.command.communicate(timeout=60)
            wrong = ["a traceback"] if "Traceback" in said else []
            while (left := family.alive()) and time.time() < killed + GONE_S:
                time.sleep(0.1)
            wrong += [f"still running: {line}" for line in left.values()]
        try:
            wrong += victim.problems(folder, killed)
        except (PipenavError, OSError) as error:
            wrong.append(f"{type(error).__name__}: {error}")
        if victim.earlier:
            _whole(victim, folder)
            wrong += [f"{path} is left" for path in folder.rglob(".*")]
        return wrong


def _whole(victim: Victim, folder: Path) -> None:
    with started(*victim.words, folder=folder) as family:
        said, _ = family.command.communicate()
        assert family.command.returncode == 0, said


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200, help="in all")
    parser.add_argument("--only", nargs="+", choices=VICTIMS, default=list(VICTIMS), help="these commands")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng, failed = random.Random(given.seed), 0
    for i in range(given.kills):
        name, number = given.only[i % len(given.only)], SIGNALS[i // len(given.only) % len(SIGNALS)]
        after = rng.uniform(0.0, VICTIMS[name].latest)
        wrong = kill(VICTIMS[name], number, after)
        failed += bool(wrong)
        for line in wrong:
            print(f"{i}: {name}, {signal.Signals(number).name} after {after:.2f} s: {line}", flush=True)
    print(f"{given.kills} kills of {', '.join(given.only)}: {failed} left something wrong")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
