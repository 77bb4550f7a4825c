"""`pipenav eval`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from pipenav.errors import PipenavError


def evaluate(
    policy: Annotated[
        str, typer.Option(help="best.zip, a shipped policy's name, baseline:random or baseline:centreline.")
    ],
    backend: Annotated[str, typer.Option(help="Simulator backend; see `pipenav backends`.")] = "mujoco",
    pipes: Annotated[
        list[str] | None, typer.Option(help="Shipped set, FILE.toml or d=90,angle=60[,turn=right]; repeatable.")
    ] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes per pipe.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Seed of starts and targets.")] = 0,
    robot: Annotated[str, typer.Option(help="Robot of a baseline; a policy brings its own.")] = "basic",
    option: Annotated[list[str] | None, typer.Option(help="Backend setting, key=value; repeatable.")] = None,
    out: Annotated[Path | None, typer.Option(help="Evaluation folder; default beside the policy.")] = None,
) -> None:
    """Measure in which pipes a policy passes: success with 95 % intervals, failures, clearance, contact, pictures.

    Examples:

        pipenav eval --policy runs/arm/best.zip

        pipenav eval --policy arm --pipes thesis --episodes 100

        pipenav eval --policy baseline:centreline --pipes d=90,angle=60 --pipes d=90,angle=60,turn=right

        pipenav eval --policy arm --option timestep=0.001
    """
    from pipenav.controller import open_controller
    from pipenav.evaluate import run_episodes, summarise
    from pipenav.files import prepare_folder
    from pipenav.pipe_set import parse_pipes
    from pipenav.registry import check_options, load_backend
    from pipenav.report import evaluation_table, write_evaluation

    names = pipes or ["working-range"]
    parsed = parse_pipes(names)
    controller = open_controller(policy, robot, seed)
    options = parse_options(option or [])
    check_options(backend, load_backend(backend), options)
    folder = out or _default_folder(policy, names)
    prepare_folder(folder)
    console = Console()
    total = len(parsed) * episodes
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed} of {task.total} episodes"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("success", total=total)

        def report(done: int, successes: int) -> None:
            bar.update(task, completed=done, description=f"success {successes / done:.1%}")

        results = run_episodes(controller, parsed, episodes, seed, backend, options, report)
    evaluation = summarise(results, parsed, episodes, policy, backend, controller, seed, options)
    write_evaluation(folder, evaluation)
    console.print(evaluation_table(evaluation))
    console.print(f"evaluation folder {folder}: eval.json, eval.csv, success.png, map.png")


def parse_options(given: list[str]) -> dict[str, Any]:
    """`key=value` texts as a table; values as in TOML."""
    from pipenav.train_config import toml_value

    options = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals:
            raise PipenavError(f"option {text!r} has no value: write it as key=value, for example timestep=0.001.")
        options[key.strip()] = toml_value(value.strip())
    return options


def _default_folder(policy: str, pipes: list[str]) -> Path:
    """`eval-<pipes>` beside a policy file; under `runs/` for shipped policies and baselines."""
    label = "-".join(Path(name).stem.replace("=", "").replace(",", "-") for name in pipes)
    path = Path(policy)
    if path.suffix == ".zip":
        return path.parent / f"eval-{label}"
    return Path("runs") / policy.replace(":", "-") / f"eval-{label}"
