"""The folder of an evaluation: its name by default, which tells evaluations apart, and what it must not replace."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.results import Evaluation, read_evaluation
from pipenav.policies.named import BASELINE, BASELINES
from pipenav.policies.policy import resolve_policy
from pipenav.storage.shipped import policies_dir

RECORD = "eval.json"

UNFINISHED = "unfinished"
"""Folder in an evaluation folder with the parts that are finished, until all are."""

UNNAMED_STAGES = (None, "reach", "traverse")
"""Stages that the name of an evaluation folder leaves out: the policy's own task."""

DEFAULT_ROBOT = "basic"
"""Robot that locates a target where no other is named."""

BEST = "best"
"""Name of the policy file, without its suffix, that the name of an evaluation folder leaves out."""

MOST_NAME = 120
"""Most characters of a folder's name; a longer one ends in a number made from the whole of it."""

RUNS = Path("runs")


def default_folder(config: EvaluationConfig) -> Path:
    """Folder of an evaluation: `eval-...` beside a policy file, in a folder below `runs/` otherwise.

    Its name has everything in which the evaluation differs from one with default settings. A shipped policy has the
    folder `shipped-NAME`, so that it never meets a training of one's own that is called NAME.
    """
    name = label(["eval", *_parts(config)])
    if config.policy is None:
        return RUNS / label(["locate", config.robot or DEFAULT_ROBOT, config.variant]) / name
    if config.policy.startswith(BASELINE):
        return RUNS / label([config.policy]) / name
    file = resolve_policy(config.policy)
    if file.resolve().is_relative_to(policies_dir().resolve()):
        return RUNS / label(["shipped", file.resolve().parent.name]) / name
    return file.parent / name


def check_folder(folder: Path, config: EvaluationConfig) -> None:
    """Refuse a folder that holds another evaluation; one of the same configuration may be repeated in it.

    Raises:
        PipenavError: the folder holds an evaluation that differs, or one that cannot be read.
    """
    if not (folder / RECORD).is_file():
        return
    try:
        earlier = read_evaluation(folder)
    except PipenavError as error:
        raise PipenavError(f"{str(error).rstrip('.')}; move {folder} away, or choose another --out.") from error
    differences = [
        f"{pair.key} {_shown(pair.there)} there, {_shown(pair.now)} now"
        for pair in _compared(earlier, config)
        if not _equal(pair.there, pair.now)
    ]
    if differences:
        raise PipenavError(
            f"{folder} holds another evaluation ({'; '.join(differences)}): choose another --out, or remove it."
        )


class _Compared(NamedTuple):
    """Key of a configuration, with its value in the folder and the one that is wanted now."""

    key: str
    there: Any
    now: Any


def _compared(earlier: Evaluation, config: EvaluationConfig) -> list[_Compared]:
    """All keys of an earlier evaluation's configuration and of the present one."""
    there, now = dict(earlier.config), dict(config)
    if there["robot"] is None or now["robot"] is None:
        there["robot"], now["robot"] = earlier.robot, config.robot or _default_robot(config, earlier.robot)
    return [_Compared(key, there[key], now[key]) for key in now]


def _default_robot(config: EvaluationConfig, brought: str) -> str:
    """Robot of an evaluation that names none; a trained policy brings its own."""
    if config.policy is None:
        return DEFAULT_ROBOT
    return BASELINES.get(config.policy.removeprefix(BASELINE), brought)


def _equal(one: Any, other: Any) -> bool:
    """Whether two values mean the same; a file may be named from another folder."""
    if isinstance(one, str) and isinstance(other, str):
        return one == other or _same_file(one, other)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_equal, one, other))
    return bool(one == other)


def _same_file(one: str, other: str) -> bool:
    """Whether two texts can name one file: the same path, or the end of one that was named from another folder."""
    paths = (Path(one), Path(other))
    if any(path.suffix not in (".zip", ".toml") for path in paths):
        return False
    short, long = sorted(([part for part in path.parts if part != ".."] for path in paths), key=len)
    return paths[0].resolve() == paths[1].resolve() or long[-len(short) :] == short


def _shown(value: Any) -> str:
    return "not set" if value is None else json.dumps(value)


def _parts(config: EvaluationConfig) -> list[str]:
    """Everything that sets an evaluation apart, as the parts of its folder's name."""
    usual = {key: field.default for key, field in type(config).model_fields.items()}
    parts = [] if config.stage in UNNAMED_STAGES else [str(config.stage)]
    policy = config.policy or ""
    if policy.endswith(".zip") and Path(policy).stem != BEST:
        parts.append(Path(policy).stem)
    parts += [_named(name) for name in config.pipes]
    if config.disturb is not None:
        parts.append(_named(config.disturb))
    if config.policy is not None:
        parts += [_named(config.robot)] if config.robot is not None else []
        parts += [config.variant] if config.variant != usual["variant"] else []
    if config.episodes != usual["episodes"]:
        parts.append(f"{config.episodes}-episodes")
    if config.seed != usual["seed"]:
        parts.append(f"seed{config.seed}")
    if config.backend != usual["backend"]:
        parts.append(config.backend)
    parts += [f"audit{100 * config.audit:g}"] if config.audit is not None else []
    parts += ["certified"] if config.certify else []
    return [*parts, *(f"{key}{value}" for key, value in sorted(config.options.items()))]


def _named(text: str) -> str:
    """A name, or a file's without its folder and suffix."""
    return Path(text).stem if text.endswith(".toml") else text


def label(parts: list[str]) -> str:
    """Parts as the name of a file or a folder: letters, digits and a few signs, and not too long."""
    given = "-".join(parts)
    name = re.sub(r"[^\w.+-]+", "-", given.replace("=", "").replace("/", "-")).strip("-")
    if len(name) <= MOST_NAME:
        return name
    return f"{name[: MOST_NAME - 9]}-{hashlib.sha256(given.encode()).hexdigest()[:8]}"
