"""Agreement of two simulators: the same trials in both, and the differences that are allowed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.simulators import SimulatorSettings
from pipenav.comparison.trials import TrialsOrder, record_passages, trials_from, trials_job
from pipenav.jobs import Job, MemoryStore, Place, run_jobs
from pipenav.jobs.here import HerePlace
from pipenav.robots.robot import RobotSpec


class SimulatorPair(NamedTuple):
    """The same array from the reference simulator and from the other one."""

    reference: Floats
    other: Floats

    @property
    def difference(self) -> Floats:
        return np.abs(self.other - self.reference)


class Agreement(NamedTuple):
    """Trials of both simulators, with the fields of `pipenav.comparison.trials.Trials`."""

    driven: SimulatorPair
    stepped: SimulatorPair
    ranges: SimulatorPair
    tips: SimulatorPair
    pressed: SimulatorPair
    force: SimulatorPair


class Check(NamedTuple):
    """Line of the table: the largest difference that was found and the largest that is allowed, in `unit`."""

    what: str
    found: float
    allowed: float
    unit: str
    reason: str

    @property
    def holds(self) -> bool:
        return self.found <= self.allowed


def compare(
    robot: RobotSpec, reference: SimulatorSettings, other: SimulatorSettings, place: Place | None = None
) -> Agreement:
    """Run all trials in both simulators, each in a job.

    Args:
        robot: the robot, a slide followed by hinges.
        reference: simulator to compare with.
        other: simulator that is compared.
        place: where the jobs run, by default this process.
    """
    passages = record_passages(robot, reference)
    store = MemoryStore()
    jobs = [
        Job(f"trials-{number}", f"trials in {one.backend}", trials_job, TrialsOrder(robot, plain, passages))
        for number, one in enumerate((reference, other))
        for plain in [one._replace(options=dict(one.options))]  # a view of a table does not pickle
    ]
    run_jobs(place or HerePlace(), jobs, store=store)
    trials = [trials_from(store.read(job.key) or b"") for job in jobs]
    return Agreement(*(SimulatorPair(*pair) for pair in zip(*trials, strict=True)))


ROTORS = "a simulator may have to carry a rotor's inertia on a link, which shifts motion by some milliseconds"
ROUNDING = "both round to the laser's resolution: one step of it"
NEXT_STEP = "a touch at the end of a control step may fall into the next"
STATICS = "the same motors press on the same walls; with friction many forces are at rest, so it is without"
SOFTNESS = "walls give way by a fraction of a millimetre"


def checks(robot: RobotSpec, agreement: Agreement) -> list[Check]:
    """Checks of the differences that matter, each with the difference that is allowed and why."""
    found, hinges, milli = agreement, robot.hinges, 1e3
    lines = []
    for what, sides in (("a pulse of duty", found.driven), ("a step of the set-point", found.stepped)):
        off = milli * sides.difference.max(axis=(0, 1))  # (joints,)
        lines.append(Check(f"free motion under {what}: hinges", off[hinges].max(), 25.0, "mrad", ROTORS))
        lines.append(Check(f"free motion under {what}: slide", off[~hinges].max(), 1.0, "mm", ROTORS))
    ranges, resolution = milli * found.ranges.difference.max(), milli * robot.laser.resolution
    lines.append(Check("laser readings in the same pose", ranges, resolution, "mm", ROUNDING))
    apart = milli * tip_distance(found)
    lines.append(Check("tip on the same passage: on the way", float(np.nanmax(apart)), 8.0, "mm", ROTORS))
    ends = [row[~np.isnan(row)][-1] for row in apart]
    lines.append(Check("tip on the same passage: at its end", max(ends), 5.0, "mm", ROTORS))
    touch = SimulatorPair(*((side > 0).argmax(axis=1) for side in found.force))
    lines.append(Check("first touch of a wall", float(touch.difference.max()), 1.0, "steps", NEXT_STEP))
    push = SimulatorPair(*(side[:, -1] for side in found.force))
    share = 100 * float((push.difference / push.reference).max())
    lines.append(Check("force at rest on a wall", share, 2.0, "%", STATICS))
    rest = milli * found.pressed.difference[:, -1, hinges].max()
    lines.append(Check("pose at rest on a wall: hinges", rest, 2.0, "mrad", SOFTNESS))
    return [check._replace(found=float(check.found)) for check in lines]


def tip_distance(agreement: Agreement) -> Floats:
    """Distance between the two tips on the passages, (corners, steps) [m]; NaN after a passage's end."""
    return np.asarray(np.linalg.norm(agreement.tips.other - agreement.tips.reference, axis=-1))
