"""A session of driving in a simulator: numbered episodes, one after another or many at once, each recorded."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.deployment.telemetry import Telemetry
from pipenav.driving.ask import PERSON, Operator, OperatorLost
from pipenav.driving.door import Door
from pipenav.driving.plans import DrivePlan
from pipenav.driving.records import EpisodeRecord
from pipenav.driving.shown import Shown, tick_record
from pipenav.driving.worlds import World, open_world
from pipenav.errors import PipenavError
from pipenav.evaluation.episode_runner import EpisodeQueue, joined, random_start
from pipenav.policies.controller import actions_of
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.outcome import Outcome

AT_ONCE = 32
"""Most robots that are driven at once, where nobody looks on."""


class EndedByPerson(Exception):  # no error: a person's wish
    """The person ended the session."""


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

    @property
    def record(self) -> dict[str, Any]:
        """The lesson, as the telemetry holds it."""
        return {"observation": self.observation.tolist(), "action": self.action.tolist(), "reward": self.reward}


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
        PipenavError: its commands are no set-points.
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
        self._operators, self._n = operators, 1 if alone else min(plan.total, AT_ONCE)
        self._doors: list[Door] = []
        self.records: list[EpisodeRecord] = []

    def run(self) -> None:
        """Run every episode; the records of those that ended are in `records`, whatever ends the session.

        Raises:
            OperatorLost: a person's device is gone.
            PipenavError: the robot cannot do the task.
        """
        plan, n = self._plan, self._n
        task = plan.lengthened
        starts = random_start(plan.robot, plan.disturbance.starts(task), plan.pipes, plan.episodes, plan.seed)
        queue: EpisodeQueue[Any] = EpisodeQueue(starts, plan.total, n)
        world, self._doors = open_world(plan, self._operators, n, lambda rows: joined(queue.take(rows)))
        with closing(world.batch):
            self._loop(world, queue)

    def _loop(self, world: World, queue: EpisodeQueue[Any]) -> None:
        plan, batch = self._plan, world.batch
        observation = batch.reset()
        running = [self._begun(int(job)) for job in queue.running]
        idle = np.zeros((batch.n, batch.action_size))
        try:
            while len(self.records) < plan.total:
                action = idle if plan.controller is None else actions_of(plan.controller, observation, batch)
                before, seen = world.readings(), observation
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
                self._look(world, running[0])
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
                # In space a robot drives itself between corners, which is no lesson for a policy.
                **({} if plan.in_space else {"task": plan.task.model_dump(mode="json")}),
            }
        )
        return _Episode(telemetry)

    def _note(self, episode: _Episode, i: int, reading: Reading, lesson: Lesson, truth: Any) -> None:
        """Note a control step of a running episode."""
        door = self._doors[i]
        command = door.told
        if episode.before is not None:
            jump = np.abs(command - episode.before) / door.limits
            episode.jump = max(episode.jump, float(jump.max()))
        episode.before = command
        episode.by_person += door.who == PERSON
        force, penetration = float(truth.contact_force[i]), float(truth.penetration[i])
        if np.isfinite(force) and np.isfinite(penetration):
            episode.force = max(episode.force, force)
            episode.penetration = max(episode.penetration, penetration)
        if episode.telemetry is not None:
            taught = {} if self._plan.in_space else lesson.record
            episode.telemetry.tick({**tick_record(episode.steps, door, reading, force), **taught})
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

    def _look(self, world: World, episode: _Episode) -> None:
        picture = None if self._show is None else world.picture()
        if self._show is None or picture is None:
            return
        reading, seconds = world.readings().part(np.array([0])), episode.steps * CONTROL_PERIOD
        self._show(Shown(picture, reading, self._doors[0], seconds, episode.force, world.window))
