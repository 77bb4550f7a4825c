"""Whether a model that was written acts as the policy that it came from, on observations recorded in a simulator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.simulators import SimulatorSettings, load_simulator
from pipenav.errors import PipenavError
from pipenav.evaluation.passage import run_task
from pipenav.pipes.pipe import Pipe
from pipenav.policies.file import Array32
from pipenav.policies.named import PolicyController
from pipenav.policies.policy import Policy
from pipenav.tasks.reach.episode import check_fits
from pipenav.tasks.registry import task_of

TOLERANCE = 1e-5
"""Largest difference of an action, of which a full one is 1, that passes: a hundred roundings of float32."""

AT_ONCE = 64
"""Episodes that are recorded at once."""

ReportProgress = Callable[[int], None]
"""Called with the observations that are recorded so far."""


class Parity(NamedTuple):
    """Comparison of two ways to run one policy.

    Attributes:
        observations: number of observations compared.
        largest: largest absolute difference of an action.
        passed: whether it is at most `TOLERANCE`.
    """

    observations: int
    largest: float

    @property
    def passed(self) -> bool:
        return self.largest <= TOLERANCE


class _Recorder(PolicyController):
    """The policy as a controller that keeps every observation that it acts on."""

    def __init__(self, policy: Policy, report_progress: ReportProgress) -> None:
        super().__init__(policy)
        self.kept: list[Floats] = []
        self.count, self._report_progress = 0, report_progress

    def act(self, observation: Floats) -> Floats:
        self.kept.append(observation.copy())
        self.count += len(observation)
        self._report_progress(self.count)
        return super().act(observation)


class ObservationSource:
    """Observations of a policy that drives its robot in a simulator.

    Args:
        policy: the policy.
        pipes: pipes, as a person names them; by default those that it was trained in. Those that leave a plane are left
            out.
        backend: name of the simulator.

    Raises:
        PipenavError: a pipe is unknown or too narrow, none lies in a plane, or there is no such simulator.
    """

    def __init__(self, policy: Policy, pipes: Sequence[str] | None = None, backend: str = "mujoco") -> None:
        header = policy.header
        parsed = task_of(header.task).parse_pipes(pipes or header.train_pipes)
        self._policy, self._simulator = policy, SimulatorSettings(backend)
        self._pipes = [pipe for pipe in parsed if not pipe.in_space]
        if not self._pipes:
            raise PipenavError(
                f"{' and '.join(pipes or header.train_pipes)} leave the plane, where no observations are recorded: "
                "name others by --pipes."
            )
        load_simulator(backend)
        check_fits(header.robot, self._pipes)

    def record(self, count: int, report_progress: ReportProgress = lambda _: None) -> Floats:
        """Scaled observations that the policy acts on, (count, size), from as many episodes as that takes."""
        recorder, seed = _Recorder(self._policy, report_progress), 0
        while recorder.count < count:
            run_task(recorder, _spread(self._pipes, seed), 1, seed, self._simulator)
            seed += 1
        return np.concatenate(recorder.kept)[:count]


def _spread(pipes: Sequence[Pipe], turn: int) -> list[Pipe]:
    """Some pipes from all over a list, others at every turn."""
    step = max(len(pipes) // AT_ONCE, 1)
    return list(pipes[turn % step :: step])[:AT_ONCE]


def compare(policy: Policy, act: Callable[[Array32], Array32], scaled: Floats) -> Parity:
    """Comparison of a policy with a model of it.

    Args:
        policy: the policy.
        act: the model: actions in [-1, 1], (n, action_size), from unscaled observations, (n, size) float32.
        scaled: observations as the policy takes them, (n, size).
    """
    unscaled = (np.asarray(scaled, float) * policy.observation_scale).astype(np.float32)
    difference = np.abs(policy.act(scaled).astype(float) - act(unscaled))
    largest = float(np.max(difference, initial=0.0)) if np.isfinite(difference).all() else float("inf")
    return Parity(len(scaled), largest)
