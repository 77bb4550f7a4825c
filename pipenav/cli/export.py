"""`pipenav export`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import typer

from pipenav.cli.options import BackendOption
from pipenav.cli.terminal import progress_console, say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.arrays import Floats
    from pipenav.policies.file import Array32
    from pipenav.policies.policy import Policy
    from pipenav.portable.parity import ObservationSource

CHECK = "Check against the policy"

PolicyOption = Annotated[str, typer.Option(help="best.zip or a shipped policy's name.", show_default=False)]
ToOption = Annotated[
    Literal["onnx", "torchscript"],
    typer.Option(help="onnx, for onnxruntime and many others; torchscript, for PyTorch from C++.", show_default=False),
]
OutOption = Annotated[
    Path | None,
    typer.Option(help="File to write.", show_default="best.onnx or best.pt beside the policy, or in runs/"),
]
ObservationsOption = Annotated[
    int,
    typer.Option(min=1, max=1_000_000, help="Observations, recorded in the simulator first.", rich_help_panel=CHECK),
]
PipesOption = Annotated[
    list[str] | None,
    typer.Option(
        help="Pipes to record in, as for `pipenav eval`; repeatable.",
        show_default="those of its training",
        rich_help_panel=CHECK,
    ),
]


class _Format(NamedTuple):
    """A format of models: suffix of its files, how a policy is written, and how what was written is run."""

    suffix: str
    write: Callable[[Policy], bytes]
    run: Callable[[bytes], Callable[[Array32], Array32]]


def export(
    policy: PolicyOption,
    to: ToOption,
    out: OutOption = None,
    observations: ObservationsOption = 10_000,
    pipes: PipesOption = None,
    backend: BackendOption = "mujoco",
) -> None:
    """Write a policy as an ONNX or TorchScript model for other programs, and compare it with the policy.

    The model takes observations in physical units, in the order of the policy file, and gives actions in [-1, 1] and
    in physical units. Names, units and scales are in its metadata. It is written only where its actions
    differ from the policy's by 1e-5 at most on all recorded observations. ONNX needs the extra `export`.

    Examples:

        pipenav export --policy arm --to onnx
        pipenav export --policy runs/arm/best.zip --to torchscript --out arm.pt
        pipenav export --policy pirate --to onnx --observations 2000 --pipes d=90,angle=75
    """
    from pipenav.policies.named import BASELINE
    from pipenav.policies.policy import load_policy, resolve_policy
    from pipenav.portable.parity import ObservationSource
    from pipenav.storage.atomic_files import atomic_write, check_outputs, used_folder

    if policy.startswith(BASELINE):
        raise PipenavError(f"{policy} is a program without weights, which no model can hold: name a trained policy.")
    opened = load_policy(resolve_policy(policy))
    source, kind = ObservationSource(opened, pipes, backend), _formats()[to]
    path = out or _default_file(policy, kind.suffix)
    with nullcontext() if out else used_folder(path.parent):
        check_outputs([path], [opened.path])
        content = kind.write(opened)
        _check_parity(opened, kind.run(content), _recorded(source, observations))
        atomic_write(path, content)
    sizes = f"{len(opened.observation_scale)} observed values, {len(opened.header.action)} actions"
    say(f"written: {path}, {sizes}, {opened.header.rate_hz:g} a second")


def _check_parity(policy: Policy, act: Callable[[Array32], Array32], scaled: Floats) -> None:
    """Print how far a model's actions are from the policy's, and refuse one that is too far."""
    from pipenav.portable.parity import TOLERANCE, compare

    parity = compare(policy, act, scaled)
    say(f"parity: largest difference of an action {parity.largest:.2g} over {parity.observations:,} observations")
    if not parity.passed:
        raise PipenavError(
            f"the model's actions differ from the policy's by up to {parity.largest:.2g}, allowed is {TOLERANCE:g}: "
            "nothing is written; please send the policy to the maintainers of pipenav."
        )


def _formats() -> dict[str, _Format]:
    from pipenav.portable import onnx_file, torchscript_file

    return {
        "onnx": _Format(".onnx", onnx_file.onnx_bytes, onnx_file.onnx_runner),
        "torchscript": _Format(".pt", torchscript_file.torchscript_bytes, torchscript_file.torchscript_runner),
    }


def _default_file(policy: str, suffix: str) -> Path:
    """File beside a policy file; of a shipped policy in the folder of its evaluations."""
    from pipenav.evaluation.config import EvaluationConfig
    from pipenav.evaluation.folder import default_folder

    return default_folder(EvaluationConfig(policy=policy)).parent / f"best{suffix}"


def _recorded(source: ObservationSource, count: int) -> Floats:
    """Recorded observations, under a bar."""
    from pipenav.cli.progress_bars import episode_bar

    with episode_bar(progress_console(), "observations") as bar:
        task = bar.add_task("recording", total=count)
        return source.record(count, lambda done: bar.update(task, completed=min(done, count)))
