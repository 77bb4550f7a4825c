"""Every format that pipenav reads: files that are right, and the reader that a mutated one is given to."""

from __future__ import annotations

import io
import json
import tomllib
import zipfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
EARLIER = ROOT / "tests" / "data" / "0.1"
MISSION = EARLIER / "mission"


_TYPED = [
    b"d=90,tee=60,way=out,turn=right",
    b"d=90,angle=60",
    b"d=100,angle=75,turn=right,bend_radius=50",
    b"d=90,angle=90,bend_radius=1.5D",
    b"runs-level:3",
]

_FITTINGS = b"""schema = 3
diameter_mm = 110
slope_deg = 20
capped = true
[[corners]]
angle_deg = 90
turn = "left"
bend_radius_mm = 165
[[corners]]
to_diameter_mm = 80
length_mm = 110
straight_mm = 500
[[corners]]
angle_deg = 75
turn = "right"
roll_deg = 90
[[corners]]
[[corners.branches]]
angle_deg = 60
turn = "left"
capped = true
"""

_NETWORK = b"""schema = 1
[nodes]
a = { at_mm = [0, 0] }
b = { at_mm = [800, 0, 0], bend_radius_mm = 150 }
c = { at_mm = [800, 700] }
d = { at_mm = [800, 1500, 0], capped = true }
e = { at_mm = [1500, 700] }
[[pipes]]
from = "a"
to = "b"
diameter_mm = 100
[[pipes]]
from = "b"
to = "c"
diameter_mm = 100
[[pipes]]
from = "c"
to = "d"
diameter_mm = 100
[[pipes]]
from = "c"
to = "e"
diameter_mm = 80
[routes]
main = ["a", "b", "c", "e"]
"""


class Format(NamedTuple):
    """A format.

    Attributes:
        suffix: suffix of its files.
        seeds: contents of files that are right.
        open: reader of a file at a path.
    """

    suffix: str
    seeds: list[bytes]
    open: Callable[[Path], Any]


@lru_cache(maxsize=1)
def formats() -> dict[str, Format]:
    """The formats by name."""
    return {
        "robot": Format(".toml", _files("models/robots/*/robot.toml", "tests/data/0.1/robots/*.toml"), _robot),
        "config": Format(".toml", _files("pipenav/learning/presets/*.toml", "tests/data/0.1/recipe.toml"), _config),
        "space": Format(".toml", _files("pipenav/tuning/spaces/*.toml"), _space),
        "set": Format(".txt", [b"learner.epochs=4", b"task.reward.c1=0.5", b"pipes=['d=100,angle=90']"], _set),
        "disturbance": Format(".toml", _files("pipenav/disturbances/*.toml"), _disturbance),
        "pipe-set": Format(".toml", _files("pipes/*.toml"), _pipes),
        "route": Format(".toml", [*_files("tests/data/0.1/my-run.toml"), _FITTINGS], _route),
        "route-set": Format(".toml", _files("pipes/runs/*.toml"), _pipes),
        "network": Format(".toml", [_NETWORK], _network),
        "typed-pipe": Format(".txt", _TYPED, _typed),
        "pipe-json": Format(".json", _files("tests/data/0.1/corner-*/pipe.json"), _pipe_json),
        "run-json": Format(".json", [*_files("tests/data/0.1/my-run/run.json"), _fittings()], _run_json),
        "trajectory": Format(".csv", _files("tests/data/0.1/*.csv"), _trajectory),
        "eval-json": Format(".json", _files("tests/data/0.1/evaluation*/eval.json"), _evaluation),
        "policy-header": Format(".json", [_header(MISSION / "policy.zip")], _policy),
        "policy": Format(".zip", [(EARLIER / "training" / "best.zip").read_bytes()], _policy_file),
        "training-config": Format(".json", _files("tests/data/0.1/training/config.json"), _training_config),
        "progress": Format(".csv", _files("tests/data/0.1/training/progress.csv"), _progress),
        "checkpoint": Format(".safetensors", _files("tests/data/0.1/training/resume.safetensors"), _checkpoint),
        "telemetry": Format(".jsonl", _files("tests/data/0.1/mission/telemetry.jsonl"), _telemetry),
        "elapsed": Format(".json", [b'{"seconds": 12.5}'], _elapsed),
        "faults": Format(".json", [_faults()], _fault_script),
        "arm": Format(".toml", [_arm("basic"), _arm("real-setup")], _load_arm),
    }  # fmt: skip


def tree_of(name: str, content: bytes) -> Any:
    """The values in a file that is right; None where it is no TOML or JSON."""
    kind = formats()[name].suffix
    if kind == ".toml":
        return tomllib.loads(content.decode())
    return json.loads(content) if kind == ".json" else None


def _files(*patterns: str) -> list[bytes]:
    return [path.read_bytes() for pattern in patterns for path in sorted(ROOT.glob(pattern))]


def _header(path: Path) -> bytes:
    with zipfile.ZipFile(path) as archive:
        return archive.read("pipenav.json")


def _faults() -> bytes:
    from pipenav.deployment.emulation import THESIS_FAULTS

    more = [
        {"fault": "delay", "value": 0.5, "servo": 1, "at": 2.0, "span": 1.0},
        {"fault": "model", "value": 12.0, "tick": 3},
    ]
    return json.dumps([*THESIS_FAULTS, *more]).encode()


def _arm(robot: str) -> bytes:
    from pipenav_hardware.arm_config import FrontSensorConfig, ScannerConfig, arm_toml, default_arm

    from pipenav.robots.robot import load_robot

    scanner, front = ScannerConfig(driver="scip2", port="/dev/ttyACM0"), FrontSensorConfig(port="/dev/ttyACM1")
    return arm_toml(default_arm(load_robot(robot), "/dev/ttyUSB0", scanner, front)).encode()


def _fittings() -> bytes:
    from pipenav.export.route_folder import route_record
    from pipenav.pipes.route_file import RouteFile

    route = RouteFile.model_validate(tomllib.loads(_FITTINGS.decode())).route()
    return json.dumps(route_record(route, "fittings")).encode()


def _robot(path: Path) -> None:
    from pipenav.robots.robot import load_robot

    load_robot(str(path))


def _config(path: Path) -> None:
    from pipenav.learning.config import load_config

    load_config(file=path)


def _space(path: Path) -> None:
    from pipenav.tuning.space import load_space

    load_space(str(path))


def _set(path: Path) -> None:
    from pipenav.learning.config import load_config

    load_config("arm", settings=[path.read_text(errors="replace")])


def _disturbance(path: Path) -> None:
    from pipenav.disturbances.disturbance import load_disturbance

    load_disturbance(str(path))


def _pipes(path: Path) -> None:
    from pipenav.pipes.route_sets import parse_pipes

    parse_pipes([str(path)])


def _route(path: Path) -> None:
    from pipenav.pipes.route_sets import parse_route

    parse_route(str(path))
    _pipes(path)


def _network(path: Path) -> None:
    from pipenav.pipes.network_file import read_network

    read_network(path)
    _pipes(path)


def _typed(path: Path) -> None:
    from pipenav.pipes.route_sets import parse_pipes

    parse_pipes([path.read_text(errors="replace")])


def _pipe_json(path: Path) -> None:
    from pipenav.export.corner_folder import read_pipe

    read_pipe(path)


def _run_json(path: Path) -> None:
    from pipenav.export.route_folder import read_route_folder

    read_route_folder(path)


def _trajectory(path: Path) -> None:
    from pipenav.motions.trajectory_file import read_trajectory

    read_trajectory(path)


def _evaluation(path: Path) -> None:
    from pipenav.evaluation.results import read_evaluation

    read_evaluation(path)


def _policy(path: Path) -> None:
    from pipenav.policies.file import parse

    original, buffer = MISSION / "policy.zip", io.BytesIO()
    with zipfile.ZipFile(original) as source, zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("pipenav.json", path.read_bytes())
        archive.writestr("policy.safetensors", source.read("policy.safetensors"))
    parse(path, buffer.getvalue())


def _policy_file(path: Path) -> None:
    from pipenav.policies.policy import load_policy

    load_policy(path)


def _training(path: Path, name: str) -> Any:
    """The training folder of 0.1 with one of its files changed."""
    from pipenav.learning.training_folder import TrainingFolder

    folder = path.parent / "training"
    folder.mkdir(exist_ok=True)
    for file in ("config.json", "progress.csv", "resume.safetensors"):
        (folder / file).write_bytes((path if file == name else EARLIER / "training" / file).read_bytes())
    return TrainingFolder.open(folder)


def _training_config(path: Path) -> None:
    _training(path, "config.json")


def _progress(path: Path) -> None:
    from pipenav.learning.figures import training_figure
    from pipenav.learning.progress import progress_columns, read_progress

    _training(path, "progress.csv")
    training_figure(progress_columns(read_progress(path)), "x")


_models: list[Any] = []


def _checkpoint(path: Path) -> None:
    from contextlib import closing

    import numpy as np

    from pipenav.learning.checkpoint import load_checkpoint
    from pipenav.learning.train import new_model, training_env

    folder, config = _training(path, "resume.safetensors")
    if not _models:
        small = config.model_copy(update={"options": {"threads": 1}})
        with closing(training_env(small, np.random.default_rng(0))) as env:
            _models.append(new_model(small, env))
    load_checkpoint(folder.checkpoint, _models[0])


def _telemetry(path: Path) -> None:
    from pipenav.deployment.picture import mission_picture
    from pipenav.deployment.replay import replay
    from pipenav.policies.policy import load_policy

    copy = path.with_name("policy.zip")
    copy.write_bytes((MISSION / "policy.zip").read_bytes())
    result = replay(path)
    if result.difference and hash(result.difference) % 10 == 0:
        mission_picture(load_policy(copy).header.robot, result.recording.ticks[: result.ticks], "x")


def _elapsed(path: Path) -> None:
    from pipenav.experiments.plan import read_number

    read_number(path, "seconds")


def _fault_script(path: Path) -> None:
    from pipenav_hardware.emulator.faults import fault_script

    from pipenav.deployment.emulation import _named_faults

    fault_script(_named_faults(str(path)))


def _load_arm(path: Path) -> None:
    from pipenav_hardware.arm_config import load_arm

    from pipenav.robots.robot import load_robot

    arm = load_arm(path)
    arm.require(load_robot(arm.robot))
    arm.count_limits.sum()
