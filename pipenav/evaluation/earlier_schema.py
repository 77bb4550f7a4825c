"""Schema 1 of eval.json, which pipenav 0.1 wrote: its keys as those of today, its settings as a configuration."""

from __future__ import annotations

from typing import Any

EARLIER_KEYS = {"run": "route", "min_clearance_m": "min_range_m"}
"""Keys of schema 1 that have another name in schema 2; besides, `front_` is called `reach_` today."""

LOCATING = "locate:"
"""Beginning of what schema 1 called the policy where a target was located without one."""


def todays_keys(given: Any) -> Any:
    """A record with the keys of schema 2."""
    return {_todays_key(key): value for key, value in given.items()} if isinstance(given, dict) else given


def _todays_key(key: str) -> str:
    key = EARLIER_KEYS.get(key, key)
    return f"reach_{key.removeprefix('front_')}" if key.startswith("front_") else key


def todays_evaluation(given: Any) -> Any:
    """A whole eval.json of schema 1 as one of schema 2; anything else as it is.

    Schema 1 has the settings as single keys, and does not say which pipes were asked for: the configuration names each.
    """
    if not isinstance(given, dict) or "config" in given or given.get("schema") != 1:
        return given
    policy, pipes = str(given.get("policy")), given.get("pipes")
    located = policy.startswith(LOCATING)
    config = {
        "policy": None if located else policy,
        "pipes": [_typed_pipe(record) for record in pipes] if isinstance(pipes, list) else [],
        "episodes": given.get("episodes_per_pipe"),
        **{key: given[key] for key in ("seed", "stage", "backend", "options", "disturb") if key in given},
    }
    if located:
        config |= {"variant": policy.removeprefix(LOCATING), "robot": given.get("robot")}
    return {**given, "schema": 2, "config": config}


def _typed_pipe(record: Any) -> str:
    """A record's pipe as a person names it: a corner by its dimensions, a route by its name."""
    if not isinstance(record, dict):
        return "?"
    if record.get("run"):
        return str(record["run"])
    return f"d={record.get('diameter_mm')},angle={record.get('angle_deg')},turn={record.get('turn')}"
