"""Evaluations: some stages over many episodes in many pipes, counted pipe by pipe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from pipenav.backends.registry import check_options, load_simulator
from pipenav.disturbances.disturbance import UNDISTURBED, load_disturbance
from pipenav.errors import PipenavError
from pipenav.evaluation.passage import Passages, Progress, StageResult
from pipenav.evaluation.results import Evaluation, PipeRecord
from pipenav.evaluation.rolling_stage import check_in_space
from pipenav.evaluation.thesis import thesis_best
from pipenav.locating.locator import Variant
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import open_controller
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import TaskConfig
from pipenav.tasks.reach.episode import check_fits
from pipenav.tasks.registry import AnyTask, kind_of
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.units import m_to_mm, rad_to_deg

StageName = Literal["front", "front-rear", "locate", "passage", "traverse"]


class EvaluationRun:
    """An evaluation of some stages that has been checked and can begin.

    Args:
        policy: as `pipenav.policies.controller.open_controller` takes it; None for the stage locate.
        pipes: as `pipenav.pipes.corner_sets.parse_pipes` takes them, of a whole robot `pipenav.pipes.route_sets.parse_any`.
        episodes: in each pipe.
        seed: of starts and targets.
        stage: what to run; by default what the policy was trained for, a front passage or a traverse.
        robot: of the stage locate and of baselines, `basic` where none is named; a policy brings its own.
        variant: of approach I.
        backend: name of a simulator backend.
        options: the backend's own settings.
        disturb: as `pipenav.disturbances.disturbance.load_disturbance` takes it; None for nothing.

    Raises:
        PipenavError: something is unknown, the robot does not fit into a pipe, or there is no policy where one is
            needed.
    """

    def __init__(
        self,
        policy: str | None,
        pipes: Sequence[str],
        episodes: int,
        seed: int,
        stage: StageName | None = None,
        robot: str | None = None,
        variant: Variant = "map",
        backend: str = "mujoco",
        options: dict[str, Any] | None = None,
        disturb: str | None = None,
    ) -> None:
        if (policy is None) != (stage == "locate"):
            raise PipenavError(
                f"stage {stage} measures a policy: give --policy, for example --policy arm."
                if policy is None
                else "stage locate runs without a policy: leave out --policy."
            )
        self._policy, self._variant = policy, variant
        self._episodes, self._seed = episodes, seed
        self._controller = None if policy is None else open_controller(policy, robot, seed)
        self._robot = load_robot(robot or "basic") if self._controller is None else self._controller.robot
        self._task: AnyTask = TaskConfig() if self._controller is None else self._controller.task
        self._stage: StageName = stage or kind_of(self._task).stage
        self._check_stage()
        self._pipes = kind_of(self._task).parse_tried(pipes)
        self._backend, self._options = backend, dict(options or {})
        check_options(backend, load_simulator(backend), self._options)
        check_fits(self._robot, self._pipes)
        self._disturb, self._disturbance = disturb, UNDISTURBED if disturb is None else load_disturbance(disturb)
        if not all(pipe.planar for pipe in self._pipes):
            check_in_space(self._robot, backend, disturb)

    def _check_stage(self) -> None:
        traverses = isinstance(self._task, TraverseConfig)
        if self._controller is not None and traverses != (self._stage == "traverse"):
            does = "traverses the pipe as a whole" if traverses else "reaches a target around the corner"
            fits = "traverse" if traverses else "front, front-rear or passage"
            raise PipenavError(f"policy {self._policy} {does}: its stage is {fits}, given {self._stage}.")

    def run(self, progress: Progress = lambda _part, _total, _done, _successes: None) -> Evaluation:
        """Every stage over all episodes, one after the other."""
        pipes, episodes, controller = self._pipes, self._episodes, self._controller
        runs = Passages(
            self._robot,
            self._task,
            pipes,
            episodes,
            self._seed,
            self._backend,
            self._options,
            progress,
            self._disturbance,
        )
        parts: dict[str, StageResult] = {}
        if self._stage in ("locate", "passage"):
            parts["locate"] = runs.locate(self._variant)
        if controller is not None:
            parts[kind_of(self._task).stage] = runs.task(controller, parts.get("locate"))
        if self._stage in ("front-rear", "passage"):
            parts["rear"] = runs.rear(parts["front"], parts.get("locate"))
        deepest = np.zeros(len(pipes) * episodes)
        for part in parts.values():
            deepest[part.jobs] = np.maximum(deepest[part.jobs], part.results.penetration)
        return Evaluation.of(
            [_pipe_record(pipe, parts, i * episodes, episodes) for i, pipe in enumerate(pipes)],
            policy=self._policy or f"locate:{self._variant}",
            backend=self._backend,
            robot=self._robot.name,
            stage=self._stage,
            seed=self._seed,
            episodes_per_pipe=episodes,
            penetration_p99_m=float(np.percentile(deepest, 99)),
            options=self._options,
            disturb=self._disturb,
            thesis={} if controller is None else thesis_best(controller.task.control, self._robot.name),
        )


def _pipe_record(pipe: Pipe, parts: dict[str, StageResult], first: int, episodes: int) -> PipeRecord:
    """The record of one pipe, whose episodes are `first` and the ones after it."""
    counts: dict[str, int] = {}
    failures: dict[str, int] = {}
    seen = []
    for name, part in parts.items():
        here = (part.jobs >= first) & (part.jobs < first + episodes)
        results, passed = part.results.select(here), part.passed[here]
        seen.append(results)
        if name == "locate":
            counts["located"] = int(passed.sum())
        else:
            counts |= {f"{name}_attempts": len(passed), f"{name}_successes": int(passed.sum())}
        for outcome in results.outcome[~passed]:
            reason = Outcome(outcome).label if name in ("front", "traverse") else f"{name} {Outcome(outcome).label}"
            failures[reason] = failures.get(reason, 0) + 1
    main = parts.get("front") or parts.get("traverse") or parts["locate"]
    timed = main.results.select((main.jobs >= first) & (main.jobs < first + episodes))
    reached = timed.outcome == Outcome.REACHED
    steps = np.concatenate([results.steps for results in seen])
    shares = np.concatenate([results.contact_share for results in seen])
    corner = pipe.corner
    return PipeRecord(
        diameter_mm=round(m_to_mm(pipe.diameter), 6),
        angle_deg=None if corner is None else round(rad_to_deg(corner.angle), 6),
        turn=None if corner is None else corner.turn,
        run=pipe.name if corner is None else None,
        episodes=episodes,
        failures=failures,
        mean_steps=float(timed.steps[reached].mean()) if reached.any() else None,
        min_clearance_m=min(float(results.clearance.min(initial=np.inf)) for results in seen),
        max_penetration_m=max(float(results.penetration.max(initial=0.0)) for results in seen),
        peak_force_n=max(float(results.force.max(initial=0.0)) for results in seen),
        contact_time_share=float((steps * shares).sum() / steps.sum()),
        **counts,
    )
