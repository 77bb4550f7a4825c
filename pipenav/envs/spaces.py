"""Spaces and `info` of a task's batch, which all environments share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.errors import PipenavError
from pipenav.tasks.batch import StepResult, TaskBatch
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.outcome import Outcome

Float32s = NDArray[np.float32]

OUTCOME_LABELS = np.array([outcome.label for outcome in Outcome])
"""Labels of the outcomes, by their numbers."""


def observation_space(batch: TaskBatch) -> spaces.Space[Float32s]:
    """Space of one robot's observations. It is unbounded: no sensor limits what an impact does to a joint's speed."""
    return cast("spaces.Space[Float32s]", spaces.Box(-np.inf, np.inf, (batch.observation_size,), np.float32))


def bounded_space(layout: Sequence[ObservationField]) -> spaces.Box:
    """Space of one robot's observations with the bound of each part; an environment clips what lies outside."""
    high = np.concatenate([np.full(len(field.scale), field.bound) for field in layout])
    return spaces.Box(-high.astype(np.float32), high.astype(np.float32), dtype=np.float32)


def within(space: spaces.Box, observation: Floats) -> Float32s:
    """Observations as the space holds them: a sound simulation reaches no bound, so that only one that fails is cut."""
    return np.clip(observation.astype(np.float32), space.low, space.high)


def checked_action(space: spaces.Space[Any], action: Any, ignored: Flags | None = None) -> Floats:
    """An action as numbers, with those of ignored robots made 0 where they are no numbers.

    Args:
        space: space of the action, of one robot or of several.
        action: action, as it was given.
        ignored: robots whose actions do not matter, (n,); None for none of them.

    Raises:
        PipenavError: an action of another shape, or one that is not a number.
    """
    given = np.array(action, float)
    if given.shape != space.shape:
        raise PipenavError(f"an action of shape {given.shape} was given: give one of shape {space.shape}.")
    missing = np.isnan(given)
    if ignored is not None:
        given[missing & ignored[:, None]] = 0.0
        missing &= ~ignored[:, None]
    if missing.any():
        where = tuple(int(i) for i in np.argwhere(missing)[0])
        entry = "".join(f"[{i}]" for i in where)
        raise PipenavError(f"action{entry} is not a number (NaN): give numbers from -1 to 1.")
    return given


def action_space(batch: TaskBatch) -> spaces.Space[Float32s]:
    """Space of one robot's actions: a share in [-1, 1] for every actuator."""
    return cast("spaces.Space[Float32s]", spaces.Box(-1.0, 1.0, (batch.action_size,), np.float32))


def step_info(result: StepResult, indices: Ints | slice = slice(None)) -> dict[str, NDArray[Any]]:
    """Contents of `info` after a step, one array for each key, (k,).

    Args:
        result: result of the step.
        indices: which robots, (k,); all by default.
    """
    outcome = result.outcome[indices]
    return {
        "outcome": OUTCOME_LABELS[outcome],
        "is_success": outcome == Outcome.REACHED.value,
        "min_range_m": result.min_range[indices],
        "contact_force_n": result.truth.contact_force[indices],
        "penetration_m": result.truth.penetration[indices],
    }


def one_info(info: Mapping[str, NDArray[Any]], i: int) -> dict[str, Any]:
    """Part of `step_info` for robot i, in Python's own types."""
    return {key: column[i].item() for key, column in info.items()}
