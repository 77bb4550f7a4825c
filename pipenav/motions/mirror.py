"""Approach II (thesis 3.5): the rear half passes as the front half did, mirrored in space and reversed in time.

The front half enters the corner by the first leg and reaches into the second. The rear half follows the other way
round: joined to the front half at its own base, it lies bent around the corner with its tip in the first leg, and is
drawn out into the second. Seen from the second leg, that is an arm in the mirrored pipe (same diameter and angle,
other turn) which leaves the corner backwards: the front's motion, reflected and played from its end to its start.

In a tee the branches are not where they are in the mirrored pipe, so only a simulation tells whether the rear passes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.errors import PipenavError
from pipenav.motions.trajectory import Motion, Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import frames, kinematics
from pipenav.robots.outline import foremost
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import PassageStage
from pipenav.units import rad_to_deg

STRAIGHT = 0.1
"""Largest hinge angle of a straight start [rad]: twice what the task starts with, and far from any corner's bend."""

SAME_POSE = 1e-3
"""Largest difference of two joint positions that count as one [rad, m]; a servo's encoder resolves 5e-3 rad."""


class HandOver(NamedTuple):
    """Jump from the front's last to the rear's first pose, which no robot performs.

    The robot's middle is the rear end of the front arm's first link, where the rear half is joined to it. At the
    front's end that point is still before the corner. When the rear motion starts, the rear arm's own base, which is
    the same point of the robot, must be as far past the corner: in between the thesis re-spawns the robot (3.5).

    Attributes:
        straight: straight distance of the robot's middle before and after the jump, in the pipe's frame [m].
        distance: distance of the two along the pipe's centre line, mitred [m].
        turn_angle: angle between the robot's headings at its middle before and after the jump [rad].
        joint_change: largest difference of a hinge between the front's last and the rear's first pose [rad]. Both are
            poses of the one arm that is re-spawned; as a mirror image has the opposite angles, it is twice the largest.
    """

    straight: float
    distance: float
    turn_angle: float
    joint_change: float


class _MiddlePose(NamedTuple):
    """Pose of the robot's middle, the first link's rear end, in its pipe's frame.

    Attributes:
        position: position, (2,) [m].
        heading: heading [rad].
    """

    position: Floats
    heading: float


def mirror(robot: RobotSpec, motion: Motion) -> Motion:
    """Mirror image of a motion about the first leg's axis: hinges change sign, slides do not, the pipe turns over.

    It is exact for every pose, as joints at zero are the straight arm on that axis. Mirroring twice changes nothing.
    """
    return Motion(motion.pipe.mirrored, motion.base, motion.q * robot.mirror_signs)


def reverse(motion: Motion) -> Motion:
    """A motion from its end to its start. Reversing twice changes nothing."""
    return motion._replace(q=motion.q[::-1])


def rear_motion(robot: RobotSpec, front: Motion) -> Motion:
    """Motion of the rear half: `[l, -theta1, ...]` of the front's, in the order T..0.

    The pipe is the front's as it is for a robot that comes by the second leg: the mirrored one, but in a tee or a cross
    the branches lie elsewhere.
    """
    return reverse(mirror(robot, front))._replace(pipe=front.pipe.turned_round)


def join(parts: Sequence[Motion]) -> Motion:
    """Join motions that follow each other, each starting in the pose in which the one before ended.

    Raises:
        PipenavError: a part is in another pipe, at another base, or does not start where the one before ended.
    """
    first = parts[0]
    rows = [first.q]
    for number, part in enumerate(parts[1:], start=2):
        if part.pipe != first.pipe or abs(part.base - first.base) > SAME_POSE:
            raise PipenavError(f"part {number} of the passage is in another pipe or at another base than part 1.")
        gap = float(np.abs(part.q[0] - rows[-1][-1]).max())
        if gap > SAME_POSE:
            raise PipenavError(
                f"part {number} of the passage starts {gap:.3g} rad or m away from where part {number - 1} ended: "
                "give the parts of one passage in their order."
            )
        rows.append(part.q[1:])
    return first._replace(q=np.concatenate(rows))


def plan_rear(parts: Sequence[Trajectory]) -> Trajectory:
    """Trajectory of the rear half for a front half's passage.

    The passage must start straight and before the corner, since the rear ends where the front began. The task starts
    with hinges bent by up to 0.05 rad, which counts as straight. A front that began where locating a target ended is
    bent; with the locating part before it, the passage begins straight again.

    Args:
        parts: recordings of the passage in their order: the front, or the locating part and then the front.

    Raises:
        PipenavError: a part did not succeed or is a rear's, the last part is no front passage, the parts do not follow
            each other, or the first pose is not straight or not before the corner.
    """
    for part in parts:
        if part.header.stage is PassageStage.REAR:
            raise PipenavError("the trajectory is a rear half's already: give the front half's.")
        if not part.succeeded:
            outcome = part.header.outcome or "not run"
            raise PipenavError(
                f"the {part.header.stage} part of the passage did not succeed (outcome: {outcome}): only a successful "
                "front passage can be mirrored."
            )
    last = parts[-1]
    if last.header.stage is PassageStage.TRAVERSE:
        raise PipenavError("a whole robot has no rear half to follow: give the trajectory of an arm.")
    if last.header.stage is not PassageStage.REACH:
        raise PipenavError(
            f"the passage ends with a part of stage {str(last.header.stage)!r}: give its front part last."
        )
    front = join([part.motion for part in parts])
    _require_straight_start(last.robot, front)
    rear = rear_motion(last.robot, front)
    header = TrajectoryHeader(
        robot=last.robot.name, pipe=rear.pipe, base_m=rear.base, stage=PassageStage.REAR, controller="mirror-rear"
    )
    return Trajectory(header, last.robot, rear.q)


def _require_straight_start(robot: RobotSpec, front: Motion) -> None:
    hinges = np.where(robot.hinges, np.abs(front.q[0]), 0.0)
    if hinges.max() > STRAIGHT:
        name = robot.joints[int(hinges.argmax())].name
        raise PipenavError(
            f"the passage does not start straight: {name} is at {rad_to_deg(float(hinges.max())):.1f} deg, allowed are "
            f"{rad_to_deg(STRAIGHT):.1f} deg; if a locating part comes before it, give that first."
        )
    if not is_out(robot, front.pipe, front.base, front.q[:1])[0]:
        raise PipenavError(
            "the passage starts with a part of the arm in the corner, where the rear half would then end: give a "
            "passage that starts before the corner."
        )


def hand_over(robot: RobotSpec, front: Motion) -> HandOver:
    """Jump from the front's last to the rear's first pose."""
    rear = rear_motion(robot, front)
    before, after = _middle(robot, front.base, front.q[-1]), _middle(robot, rear.base, rear.q[0])
    rotation = front.pipe.heading_change - math.pi  # takes the mirrored pipe's first leg onto the second leg
    cos, sin = math.cos(rotation), math.sin(rotation)
    position = np.array([[cos, -sin], [sin, cos]]) @ after.position
    # The halves are joined back to back: seen along the robot, the rear arm's base faces backwards.
    turn_angle = after.heading + rotation + math.pi - before.heading
    joint_change = np.abs(rear.q[0] - front.q[-1])[robot.hinges]
    return HandOver(
        straight=float(np.linalg.norm(position - before.position)),
        distance=float(front.pipe.distance_along(position) - front.pipe.distance_along(before.position)),
        turn_angle=abs(math.remainder(turn_angle, 2 * math.pi)),
        joint_change=float(joint_change.max(initial=0.0)),
    )


def _middle(robot: RobotSpec, base: float, q: Floats) -> _MiddlePose:
    pose = kinematics.forward(robot, q[None])
    return _MiddlePose(frames.robot_to_pipe(pose.joints[0, 0], base), float(pose.headings[0, 0]))


def is_out(robot: RobotSpec, pipe: PipeCorner, base: float, q: Floats) -> Flags:
    """Whether the whole arm lies in the first leg, before the inner wall begins to turn, (n,).

    Args:
        robot: the robot.
        pipe: the pipe.
        base: x of the robot's frame in the pipe's frame [m].
        q: joint positions, (n, joints) [rad or m].
    """
    return np.asarray(base + foremost(robot, q) <= -pipe.inner_edge)
