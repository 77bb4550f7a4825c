"""Audit of successful episodes: their recorded motions are replayed by geometry alone, without a simulator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.certify.shapes import shapes_of
from pipenav.errors import PipenavError
from pipenav.evaluation.overlap import overlaps
from pipenav.pipes.pipe import Pipe
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.registry import TaskConfig
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes

BETWEEN = 3
"""Poses that are looked at between two recorded ones."""

SPREAD = 2654435769
"""Odd number next to 2^32 over the golden ratio: its multiples, modulo 2^32, lie evenly wherever one begins to count
(D. E. Knuth, The Art of Computer Programming 3, 6.4)."""


def audited(number: int, share: float) -> bool:
    """Whether an episode is audited if it succeeds, which its number in the evaluation and the share alone decide.

    An episode that is audited at some share is audited at every larger one.
    """
    return (number * SPREAD) % 2**32 < share * 2**32


class AuditRows(NamedTuple):
    """Audits of k episodes, in order.

    Attributes:
        jobs: numbers of the episodes in the whole evaluation, (k,).
        overlap: deepest overlap with a wall in the recorded poses, (k,) [m].
        between: deepest overlap between recorded poses, (k,) [m].
        speed: largest speed of a joint between recorded poses, as a multiple of its motor's no-load speed, (k,).
        power: largest share that braking a joint against its motor's no-load speed takes of the power that all other
            motors and the falling weight can give, (k,).
        arrived: whether the tip is on the target at the end, or the tail through, (k,).
    """

    jobs: Ints
    overlap: Floats
    between: Floats
    speed: Floats
    power: Floats
    arrived: Flags

    @classmethod
    def empty(cls) -> Self:
        """No audits."""
        return cls(np.zeros(0, np.intp), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0, bool))

    def of_jobs(self, first: int, end: int) -> AuditRows:
        """Audits of the episodes from `first` to the one before `end`."""
        low, high = np.searchsorted(self.jobs, (first, end))
        return AuditRows(*(column[low:high] for column in self))  # type: ignore[arg-type]  # every column alike


class Auditor:
    """Audits the episodes of a part of an evaluation as they end, so that no motion needs to be kept.

    Args:
        robot: the robot.
        task: settings of its task.
        share: share of the successful episodes to audit.
        begin: number in the whole evaluation of the part's first episode.
    """

    def __init__(self, robot: RobotSpec, task: TaskConfig, share: float, begin: int) -> None:
        self._robot, self._task, self._share, self._begin = robot, task, share, begin
        self._shapes = shapes_of(robot)
        self._found: dict[int, tuple[float, float, float, float, bool]] = {}

    def wants(self, job: int) -> bool:
        """Whether an episode, by its number in the part, is to be audited if it succeeds."""
        return audited(self._begin + job, self._share)

    def audit(self, job: int, episode: ReachEpisodes | TraverseEpisodes, q: Floats) -> None:
        """Audit an episode that succeeded.

        Args:
            job: its number in the part.
            episode: its start and its target, of k = 1.
            q: its recorded configurations in the robot's own frame, (rows, coordinates).
        """
        (pipe,), base = episode.pipes, float(episode.base[0])
        between = np.minimum(*(self._between(pipe, base, q, curve) for curve in (_straight(q), _smooth(q))))
        self._found[job] = (
            float(self._overlaps(pipe, base, q).max()),
            float(between.max(initial=0.0)),
            float(self._speeds(q).max(initial=0.0)),
            float(self._powers(episode, q).max(initial=0.0)),
            self._arrived(episode, q[-1:]),
        )

    @property
    def rows(self) -> AuditRows:
        """The audits, by number in the whole evaluation."""
        jobs = sorted(self._found)
        if not jobs:
            return AuditRows.empty()
        overlap, between, speed, power, arrived = map(np.array, zip(*(self._found[job] for job in jobs), strict=True))
        return AuditRows(np.array(jobs, np.intp) + self._begin, overlap, between, speed, power, arrived)

    def _overlaps(self, pipe: Pipe, base: float, q: Floats) -> Floats:
        pose = kinematics.forward(self._robot, q)
        return overlaps(self._shapes, pipe.segments, frames.robot_to_pipe(pose.joints, base), pose.headings)

    def _between(self, pipe: Pipe, base: float, q: Floats, curve: Floats) -> Floats:
        """Deepest overlap between each two recorded poses, (rows - 1,) [m], on a curve (rows - 1, BETWEEN, ...)."""
        found = self._overlaps(pipe, base, curve.reshape(-1, q.shape[1]))
        return np.asarray(found.reshape(-1, BETWEEN).max(axis=1))

    def _speeds(self, q: Floats) -> Floats:
        """Mean speeds of joints between recorded poses, multiples of their no-load speeds, (rows - 1, joints)."""
        joints = q[:, q.shape[1] - len(self._robot.joints) :]
        return np.asarray(np.abs(np.diff(joints, axis=0)) / CONTROL_PERIOD / self._robot.speed_limits)

    def _powers(self, episode: ReachEpisodes | TraverseEpisodes, q: Floats) -> Floats:
        """Shares of the power at hand that joints take which are faster than their motors turn alone.

        A motor that is pushed past its no-load speed s brakes: at r times that speed, even under full voltage, it takes
        the power e s r (r - 1), with its stall effort e. The push comes from other motors through the walls, a quarter
        of e s each at most (at half of its no-load speed), and from the weight as it falls. (rows - 1, joints).
        """
        robot, speeds = self._robot, self._speeds(q)
        own = robot.effort_limits[: len(robot.joints)] * robot.speed_limits
        others = sum(one.effort_limit * one.speed_limit for one in robot.driven_actuators) - own
        fallen = np.zeros(len(speeds))
        if isinstance(episode, TraverseEpisodes):
            points = kinematics.waypoints(robot, q)
            weight = sum(body.mass for link in robot.links for body in (link, link.wheel) if body) * episode.gravity[0]
            fallen = np.maximum((np.diff(points, axis=0) @ weight).max(axis=1), 0.0) / CONTROL_PERIOD
        braking = own * speeds * np.maximum(speeds - 1.0, 0.0)
        return np.asarray(braking / (others / 4 + fallen[:, None]))

    def _arrived(self, episode: ReachEpisodes | TraverseEpisodes, last: Floats) -> bool:
        if isinstance(episode, ReachEpisodes):
            assert isinstance(self._task, ReachConfig)
            tip = frames.robot_to_canonical(kinematics.forward(self._robot, last).tip, episode.turn_sign)
            return bool(np.hypot(*(tip - episode.target)[0]) <= self._task.reach_tolerance)
        assert isinstance(self._task, TraverseConfig)
        tail = frames.robot_to_pipe(kinematics.waypoints(self._robot, last)[0, 0], episode.base[0])
        return _through(episode.pipes[0], tail, self._task.through)


def _through(pipe: Pipe, tail: Floats, through: float) -> bool:
    """Whether a tail is in the last leg, past the last corner by a distance [m]."""
    legs = pipe.leg_frames
    along, aside = (tail - legs.start[-1, :2]) @ legs.axes[-1, :2, :2]
    return bool(along >= pipe.inner_edges[-1] + through and abs(aside) <= legs.radius[-1])


def _straight(q: Floats) -> Floats:
    """Poses between recorded ones on straight ways in the joints' coordinates, (rows - 1, BETWEEN, coordinates)."""
    share = (np.arange(1, BETWEEN + 1) / (BETWEEN + 1))[:, None]
    return np.asarray(q[:-1, None] + share * (q[1:] - q[:-1])[:, None])


def _smooth(q: Floats) -> Floats:
    """Poses between recorded ones on a smooth curve through all of them, (rows - 1, BETWEEN, coordinates)."""
    from scipy.interpolate import CubicSpline

    steps = np.arange(len(q) - 1)
    share = np.arange(1, BETWEEN + 1) / (BETWEEN + 1)
    return np.asarray(CubicSpline(np.arange(len(q)), q)(steps[:, None] + share))


def check_audit(stage: str, pipes: Sequence[Pipe]) -> None:
    """Refuse an audit of what cannot be replayed.

    Raises:
        PipenavError: nothing is reached, or pipes leave the plane.
    """
    if stage == "locate":
        raise PipenavError("--audit replays motions that reach a target or pass a pipe: stage locate has none.")
    if any(pipe.in_space for pipe in pipes):
        raise PipenavError("--audit replays motions in the plane: leave out the pipes that leave it.")
