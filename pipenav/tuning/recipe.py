"""The best settings of a search as a file for `pipenav train --config`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipenav.learning.config import EXTENDS, load_config
from pipenav.tuning.plan import TunePlan
from pipenav.tuning.space import value_text
from pipenav.tuning.study import TrialRecord


def recipe_text(plan: TunePlan, record: TrialRecord, comment: str) -> str:
    """TOML with everything in which a trial's training differs from its preset.

    Args:
        plan: the search.
        record: the trial.
        comment: words about it, one line or more.
    """
    preset = load_config(plan.base.preset).model_dump(mode="json")
    config = plan.base.config(record.settings).model_dump(mode="json")
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines += [f"{EXTENDS} = {value_text(plan.base.preset)}"]
    lines += [f"description = {value_text(f'{plan.objective.title}: trial {record.number} of a search')}"]
    lines += _differences(config, preset)
    return "\n".join(lines) + "\n"


def _differences(config: Mapping[str, Any], preset: Mapping[str, Any]) -> list[str]:
    """Lines of the keys whose values differ; stages by their names where both have the same."""
    own, below = dict(config), dict(preset)
    stages = [stage["name"] for stage in own["stages"]]
    if stages and stages == [stage["name"] for stage in below["stages"]]:
        for table in (own, below):
            table["stages"] = {stage["name"]: stage for stage in table["stages"]}
        del own["steps"]  # it follows from those of the stages
    return [f"{key} = {_toml(value)}" for key, value in _changed(own, below).items() if key != "description"]


def _changed(own: Mapping[str, Any], below: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Values of `own` that `below` has not, by dotted keys."""
    found: dict[str, Any] = {}
    for key, value in own.items():
        other = below.get(key)
        if isinstance(value, Mapping) and value and isinstance(other, Mapping):
            found |= _changed(value, other, f"{before}{key}.")
        elif value != other and value is not None:
            found[before + key] = value
    return found


def _toml(value: Any) -> str:
    """A value as TOML writes it; JSON is the same except for tables."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items() if one is not None) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return value_text(value)
