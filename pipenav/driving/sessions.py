"""A session of driving in a simulator: numbered episodes, one after another or many at once, each recorded."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.backends.viewer import HasWindow
from pipenav.deployment.telemetry import Telemetry
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.driving.ask import PERSON, Operator, OperatorLost
from pipenav.driving.door import Door
from pipenav.driving.driven import DrivenSimulator
from pipenav.driving.plans import DrivePlan
from pipenav.driving.records import EpisodeRecord
from pipenav.driving.slew import SlewLimits
from pipenav.errors import PipenavError
from pipenav.evaluation.episode_runner import EpisodeQueue, joined, random_start
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import actions_of
from pipenav.robots import frames
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.registry import task_of

AT_ONCE = 32
"""Most robots that are driven at once, where nobody looks on."""


class EndedByPerson(Exception):  # no error: a person's wish
    """The person ended the session."""


class Shown(NamedTuple):
    """A control step of the first robot, as a screen shows it.

    Attributes:
        job: number of the episode, of all pipes together.
        pipe: the pipe; None where it is not known.
        points: rear end, joints and tip in the pipe's frame, (m, 2) [m].
        target: target of the tip in that frame, (2,) [m]; None where there is none.
        reading: readings of the sensors, rows of one.
        door: the door.
        seconds: time since the start [s].
        force: largest contact force so far [N].
        world: the simulator, which may have a window; None on the arm.
    """

    job: int
    pipe: Pipe | None
    points: Floats
    target: Floats | None
    reading: Reading
    door: Door
    seconds: float
    force: float
    world: HasWindow | None = None


class Lesson(NamedTuple):
    """Lesson of a control step for a policy: what it sees before it, what was done, and what that was worth.

    Attributes:
        observation: scaled observation, (size,).
        action: canonical action in [-1, 1], (action_size,).
        reward: reward of the step.
    """

    observation: Floats
    action: Floats
    reward: float


class _Episode:
    """Memory of a running episode."""

    def __init__(self, telemetry: Telemetry | None) -> None:
        self.telemetry = telemetry
        self.steps, self.by_person = 0, 0
        self.force = self.penetration = self.jump = 0.0
        self.before: Floats | None = None


class Session:
    """Runs the episodes of a plan.

    Args:
        plan: the plan.
        operators: makes the operator of a robot by its index; None for the policy alone.
        show: called after every control step, with the first robot; may raise to end the session.
        alone: whether one robot is driven at a time, as by a person.
        report: called with the number of episodes that are done and how many of them passed.

    Raises:
        PipenavError: the robot cannot do the task, or its commands are no set-points.
    """

    def __init__(
        self,
        plan: DrivePlan,
        operators: Callable[[int], Operator] | None,
        show: Callable[[Shown], None] | None = None,
        alone: bool = False,
        report: Callable[[int, int], None] = lambda _, __: None,
    ) -> None:
        self._plan, self._show, self._report = plan, show, report
        if plan.task.control != "position":
            raise PipenavError("this policy commands torques, and a person gives set-points: choose one that does too.")
        n = 1 if alone else min(plan.total, AT_ONCE)
        self._doors = [
            Door(plan.robot, operators(i) if operators else None, plan.controller is not None) for i in range(n)
        ]
        self._step_limits = SlewLimits.of(plan.robot).step
        self.records: list[EpisodeRecord] = []

    def run(self) -> None:
        """Run every episode; the records of those that ended are in `records`, whatever ends the session.

        Raises:
            OperatorLost: a person's device is gone.
        """
        plan, n = self._plan, len(self._doors)
        task = plan.lengthened
        starts = random_start(plan.robot, plan.disturbance.starts(task), plan.pipes, plan.episodes, plan.seed)
        queue: EpisodeQueue[Any] = EpisodeQueue(starts, plan.total, n)
        segments = max(len(pipe.segments) for pipe in plan.pipes)
        inner = disturbed(plan.simulator.open(plan.robot, n, segments), plan.robot, n, plan.disturbance, plan.seed)
        gap = sum(task.start_gap) / 2
        driven = DrivenSimulator(inner, self._doors, plan.controller is not None, gap)
        with closing(task_of(task).batch(plan.robot, driven, n, lambda rows: joined(queue.take(rows)))) as batch:
            driven.target = _targets(batch)
            self._loop(batch, driven, queue)

    def _loop(self, batch: TrainingBatch, driven: DrivenSimulator, queue: EpisodeQueue[Any]) -> None:
        plan = self._plan
        observation = batch.reset()
        running = [self._begun(int(job)) for job in queue.running]
        idle = np.zeros((batch.n, batch.action_size))
        try:
            while len(self.records) < plan.total:
                action = idle if plan.controller is None else actions_of(plan.controller, observation, batch)
                before, seen = driven.read(), observation
                batch.begin(action)()
                acted = self._acted(batch, action)
                result = batch.end()
                if any(door.asked.end or door.asked.stop for door in self._doors):
                    raise EndedByPerson
                observation = result.observation
                for i, episode in enumerate(running):
                    if queue.running[i] >= 0:
                        lesson = Lesson(seen[i], acted[i], float(result.reward[i]))
                        self._note(episode, i, before.part(np.array([i])), lesson, result.truth)
                self._look(batch, driven, queue, running[0])
                ended = np.flatnonzero(result.outcome != Outcome.RUNNING)
                for i in ended[queue.running[ended] >= 0].tolist():
                    outcome = Outcome(result.outcome[i])
                    self._finish(running[i], int(queue.running[i]), self._doors[i], outcome.label)
                if len(ended) and len(self.records) < plan.total:
                    observation = batch.reset(ended)
                    for i in ended.tolist():
                        running[i] = self._begun(int(queue.running[i]))
        except BaseException as stopped:
            cause = "lost" if isinstance(stopped, OperatorLost) else "ended"
            for i, episode in enumerate(running):
                if episode.telemetry is not None and queue.running[i] >= 0:
                    episode.telemetry.end("stopped", cause, str(stopped))
            raise
        finally:
            for episode in running:
                if episode.telemetry is not None:
                    episode.telemetry.__exit__(None, None, None)

    def _acted(self, batch: TrainingBatch, action: Floats) -> Floats:
        """Actions that were carried out, (n, action_size): the policy's, and what comes nearest to a person's commands.

        Args:
            batch: the robots, which have moved.
            action: the policy's actions, (n, action_size).
        """
        by_hand = np.array([i for i, door in enumerate(self._doors) if door.who == PERSON], np.intp)
        acted = np.clip(action, -1.0, 1.0)
        if len(by_hand):
            acted[by_hand] = batch.carried_out(by_hand, np.stack([self._doors[i].command for i in by_hand]))
        return acted

    def _begun(self, job: int) -> _Episode:
        plan = self._plan
        if plan.folder is None or job < 0:
            return _Episode(None)
        telemetry = Telemetry(plan.folder / f"episode-{job:04d}.jsonl")
        pipe, number = divmod(job, plan.episodes)
        telemetry.begin(
            {
                "backend": plan.simulator.backend,
                "robot": plan.robot.name,
                "pipe": plan.names[pipe],
                "episode": number,
                "seed": plan.seed,
                "robot_file": plan.robot.model_dump(mode="json"),
                "task": plan.task.model_dump(mode="json"),
            }
        )
        return _Episode(telemetry)

    def _note(self, episode: _Episode, i: int, reading: Reading, lesson: Lesson, truth: Any) -> None:
        """Note a control step of a running episode."""
        door = self._doors[i]
        command = door.command
        if episode.before is not None:
            jump = np.abs(command - episode.before) / self._step_limits
            episode.jump = max(episode.jump, float(jump.max()))
        episode.before = command
        episode.by_person += door.who == PERSON
        force, penetration = float(truth.contact_force[i]), float(truth.penetration[i])
        if np.isfinite(force) and np.isfinite(penetration):
            episode.force = max(episode.force, force)
            episode.penetration = max(episode.penetration, penetration)
        if episode.telemetry is not None:
            taught = {"observation": lesson.observation.tolist(), "action": lesson.action.tolist()}
            record = tick_record(episode.steps, door, reading, force)
            episode.telemetry.tick({**record, **taught, "reward": lesson.reward})
        episode.steps += 1

    def _finish(self, episode: _Episode, job: int, door: Door, outcome: str) -> None:
        plan = self._plan
        pipe, number = divmod(job, plan.episodes)
        self.records.append(
            EpisodeRecord(
                pipe=plan.names[pipe],
                number=number,
                outcome=outcome,
                passed=outcome == Outcome.REACHED.label,
                seconds=round(episode.steps * CONTROL_PERIOD, 6),
                takeovers=door.takeovers,
                person_share=episode.by_person / episode.steps,
                peak_force_n=episode.force,
                penetration_m=episode.penetration,
                largest_jump=episode.jump,
            )
        )
        self._report(len(self.records), sum(record.passed for record in self.records))
        if episode.telemetry is not None:
            episode.telemetry.end(outcome, None, "")
            episode.telemetry.__exit__(None, None, None)

    def _look(self, batch: TrainingBatch, driven: DrivenSimulator, queue: EpisodeQueue[Any], episode: _Episode) -> None:
        pipe = batch.pipes[0]
        if self._show is None or pipe is None:
            return
        from pipenav.robots import kinematics

        base, target = driven.bases[0], driven.target(0)
        points = kinematics.waypoints(batch.robot, batch.q[:1])[0]
        self._show(
            Shown(
                int(queue.running[0]),
                pipe,
                frames.robot_to_pipe(points, base),
                None if target is None else frames.robot_to_pipe(target, base),
                driven.read().part(np.array([0])),
                self._doors[0],
                episode.steps * CONTROL_PERIOD,
                episode.force,
                driven,
            )
        )


def tick_record(tick: int, door: Door, reading: Reading, force: float | None) -> dict[str, Any]:
    """A control step, as the telemetry holds it: who drove, what was asked for, what the robot was told."""
    asked = {key: value for key, value in door.asked._asdict().items() if value}
    record: dict[str, Any] = {
        "tick": tick,
        "stage": door.who,
        "step": door.step,
        "asked": asked,
        "q": reading.q[0].tolist(),
        "qd": reading.qd[0].tolist(),
        "ranges": reading.ranges[0].tolist(),
        "time": float(reading.time[0]),
        "command": door.command.tolist(),
        "raw": {},
    }
    if reading.wheel_speeds is not None:
        record["wheel_speeds"] = reading.wheel_speeds[0].tolist()
    if force is not None:
        record["force"] = force if np.isfinite(force) else None
    return record


def _targets(batch: TrainingBatch) -> Callable[[int], Floats | None]:
    """Target of a robot in its own frame, by the robot's index."""

    def target(i: int) -> Floats | None:
        if not isinstance(batch, ReachBatch) or batch.pipes[i] is None:
            return None
        pipe = batch.pipes[i]
        assert pipe is not None
        return frames.canonical_to_robot(batch.target[i], pipe.turn_sign)

    return target
