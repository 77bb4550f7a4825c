"""Laws about sameness: equal treatment gives equal numbers, whatever happened before and to other robots."""

from __future__ import annotations

import numpy as np

from pipenav.testing.bench import Bench, starts
from pipenav.testing.laws import require_same, state_of


def check_same_seed_same_trajectory(bench: Bench) -> None:
    """Two backends, treated alike, give the same numbers to the last bit."""
    with bench.open() as one, bench.open() as other:
        one.reset(*starts(bench))
        other.reset(*starts(bench))
        for command in bench.commands(25):
            one.step(command)
            other.step(command)
            require_same(state_of(one), state_of(other), "two backends under the same commands")


def check_reset_forgets_the_past(bench: Bench) -> None:
    """A used robot, once reset, moves as a new one does."""
    with bench.open() as used, bench.open() as new:
        used.reset(*starts(bench, seed=1))
        for command in bench.commands(15, seed=1):
            used.step(command)
        for simulator in (used, new):
            simulator.reset(*starts(bench))
        require_same(state_of(used), state_of(new), "a used and a new backend after reset")
        for command in bench.commands(15):
            used.step(command)
            new.step(command)
            require_same(state_of(used), state_of(new), "a used and a new backend under the same commands")


def check_reset_touches_only_named_robots(bench: Bench) -> None:
    """Robots that a reset does not name go on exactly as if nothing had happened."""
    chosen, others = np.arange(1, bench.n, 2), np.arange(0, bench.n, 2)
    with bench.open() as subject, bench.open() as undisturbed:
        for simulator in (subject, undisturbed):
            simulator.reset(*starts(bench))
        for i, command in enumerate(bench.commands(12)):
            if i == 6:
                again = starts(bench, seed=1)
                subject.reset(*again.part(chosen))
            subject.step(command)
            undisturbed.step(command)
            mine = {name: values[others] for name, values in state_of(subject).items()}
            theirs = {name: values[others] for name, values in state_of(undisturbed).items()}
            require_same(mine, theirs, "robots that were not reset and the same robots undisturbed")


def check_no_shared_memory(bench: Bench) -> None:
    """Arrays that were read never change afterwards, and the caller's writing into arrays changes nothing inside."""
    with bench.open() as subject, bench.open() as twin:
        start = starts(bench)
        subject.reset(*start)
        twin.reset(*starts(bench))
        start.q[:], start.base[:] = 1e3, 1e3
        for command, spoilt in zip(bench.commands(5), bench.commands(5), strict=True):
            before = state_of(subject)
            kept = {name: values.copy() for name, values in before.items()}
            subject.step(spoilt)
            spoilt.values[:] = 1e3
            require_same(before, kept, "arrays that were read before a step, and the same arrays after it")
            for values in state_of(subject).values():
                values[...] = 1e3
            twin.step(command)
            require_same(state_of(subject), state_of(twin), "a backend whose arrays the caller wrote into and its twin")


def check_closes_twice(bench: Bench) -> None:
    """Closing a backend twice is harmless, whether it was used or not."""
    with bench.open() as unused:
        unused.close()
    with bench.open() as used:
        used.reset(*starts(bench))
        used.step(bench.commands(1)[0])
        used.close()
        used.close()
