"""The command line: one thin file per subcommand, imported only when that command is asked for.

A command is a function whose docstring's first line is its line in `pipenav --help`; it raises `PipenavError` for what
a user can cause, which is printed as one line here. Exit codes: 0 done, 1 an error, 2 wrong usage, 70 a fault of
pipenav itself, with a report in a file, 128 + N ended by signal N (130 for Ctrl-C).
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

import pipenav
from pipenav.cli.plain_letters import print_plain_letters
from pipenav.cli.signals import Interrupted, interrupts
from pipenav.processes.matplotlibrc import ignore_local_matplotlibrc
from pipenav.processes.outer_settings import leave_screen_settings
from pipenav.processes.safe_path import leave_current_folder

COMMANDS = {
    "gen-pipe": (
        "pipenav.cli.gen_pipe:gen_pipe",
        "Make a pipe, a corner or a network: STL meshes, MuJoCo, URDF and SDF models, a drawing, its numbers.",
    ),
    "train": ("pipenav.cli.train:train", "Train a policy by PPO and save it as one file, best.zip."),
    "tune": (
        "pipenav.cli.tune:tune",
        "Search for better settings of a training, by many short trainings that tell where to look next.",
    ),
    "eval": (
        "pipenav.cli.eval:evaluate",
        "Measure in which pipes a policy passes: success with 95 % intervals, failures, ranges, contact, pictures.",
    ),
    "view": (
        "pipenav.cli.view:view",
        "Draw what a policy, a behaviour or a trajectory file does, from above: links, beams, target, contact forces.",
    ),
    "survey": (
        "pipenav.cli.survey:survey",
        "Find out which part of a pipe network a robot can inspect, from which entry points, and what stops it.",
    ),
    "locate-target": (
        "pipenav.cli.locate_target:locate_target",
        "Let the robot find a target (approach I), knowing only whether the corner turns left or right.",
    ),
    "mirror-rear": (
        "pipenav.cli.mirror_rear:mirror_rear",
        "Turn a front half's recorded passage into the rear half's: mirrored in space, reversed in time (approach II).",
    ),
    "certify": (
        "pipenav.cli.certify:certify",
        "Decide by geometry alone whether a robot can pass a pipe: a proof, a motion that shows it, or undecided.",
    ),
    "export": (
        "pipenav.cli.export:export",
        "Write a policy as an ONNX or TorchScript model for other programs, and compare it with the policy.",
    ),
    "experiment": (
        "pipenav.cli.experiment:experiment",
        "Train and evaluate the thesis's experiments (a)-(f), and report them beside its tables.",
    ),
    "run-real": (
        "pipenav.cli.run_real:run_real",
        "Drive the arm with a policy: locate a target, reach it, back out; safe to stop at any moment.",
    ),
    "drive": (
        "pipenav.cli.drive:drive",
        "Drive a robot by hand: joint by joint, by the tip, or by the thesis's steps (a)-(e); alone or with a policy.",
    ),
    "compare": (
        "pipenav.cli.compare:compare",
        "Put drivers beside each other on the same numbered pipes: by hand, a policy, a baseline, shared control.",
    ),
    "hw-check": (
        "pipenav.cli.hw_check:hw_check",
        "Check the arm's bus, servos and sensors; say what is missing and which cable to look at. Changes nothing.",
    ),
    "calibrate": (
        "pipenav.cli.calibrate:calibrate",
        "Describe an arm: it moves each joint a few degrees, asks which way it went, and writes arm.toml.",
    ),
    "replay": (
        "pipenav.cli.replay:replay",
        "Repeat a recorded mission's arithmetic and compare every reading, action and packet bit for bit.",
    ),
    "backends": ("pipenav.cli.backends:backends", "List the installed backends, or the settings of one."),
    "compare-backends": (
        "pipenav.cli.compare_backends:compare_backends",
        "Show how far two simulators agree: free motion, laser, passages and contact, as a table and pictures.",
    ),
    "robots": ("pipenav.cli.robots:robots", "List the robots that can be trained and driven."),
    "presets": ("pipenav.cli.presets:presets", "List the training presets, one line each."),
    "list": (
        "pipenav.cli.names:names",
        "List all that can be named: policies, pipes, disturbances, keys of files.",
    ),
}
"""Each command's function and its line in the list, which must be known without importing the function."""

EXIT_FAULT = 70
"""Exit code of a fault of pipenav itself: EX_SOFTWARE of sysexits.h."""

_SETTINGS = {"help_option_names": ["-h", "--help"]}


class LazyCommand(TyperCommand):
    """A line in the list of commands that becomes the real command as soon as it is asked for."""

    def __init__(self, name: str, target: str, help: str) -> None:
        super().__init__(name, help=help)
        self.target = target

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        from pipenav.cli.usage import UsageError, check_typed, explain

        typed, command = list(args), self.load()  # parsing takes the list apart
        try:
            context = command.make_context(info_name, args, parent, **extra)
        except UsageError as error:
            explain(error, command, typed)
            raise
        check_typed(context, typed)
        return context

    def load(self) -> Any:
        """Import the command's module and build the command from its function."""
        module, _, function = self.target.partition(":")
        callback = getattr(import_module(module), function)
        single = typer.Typer(add_completion=False, context_settings=_SETTINGS)
        single.command(self.name)(callback)
        return typer.main.get_command(single)


class CommandGroup(TyperGroup):
    """All commands; wrong usage of `pipenav` itself is explained too."""

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        from pipenav.cli.usage import UsageError, explain

        typed = list(args)
        try:
            return super().make_context(info_name, args, parent, **extra)
        except UsageError as error:
            explain(error, self, typed)
            raise

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        from pipenav.cli.usage import UsageError

        try:
            return super().resolve_command(ctx, args)
        except UsageError as error:
            if not error.message.endswith("?"):
                error.message = f"{error.message.rstrip('.')}; see pipenav --help."
            raise


def command_line() -> TyperGroup:
    """The `pipenav` command with all its subcommands."""
    app = typer.Typer(cls=CommandGroup, no_args_is_help=True, context_settings=_SETTINGS)
    app.callback()(_root)
    group = typer.main.get_command(app)
    assert isinstance(group, TyperGroup)
    for name, (target, line) in COMMANDS.items():
        group.add_command(LazyCommand(name, target, line))
    return group


def main(args: Sequence[str] | None = None) -> None:
    """Run the command line; always leaves by SystemExit.

    Args:
        args: words after `pipenav`; None for the process's arguments, and then the process ends with this.
    """
    leave_current_folder()
    ignore_local_matplotlibrc()
    leave_screen_settings()
    print_plain_letters()
    try:
        with interrupts():
            command_line()(args, prog_name="pipenav")
    except Interrupted as interrupted:
        sys.exit(128 + interrupted.number)
    except Exception as raised:
        from pipenav.errors import PipenavError

        error = _missing_module(raised) or raised
        ours = not isinstance(error, PipenavError)
        message = _fault(error) if ours else " ".join(str(error).split())
        message = "".join(letter if letter.isprintable() else "?" for letter in message)
        typer.echo(f"{typer.style('pipenav: error:', fg='red', bold=True)} {message}", err=True)
        sys.exit(EXIT_FAULT if ours else 1)
    finally:
        if args is None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done: a Ctrl-C now would only hide the exit code


def _missing_module(error: Exception) -> Exception | None:
    """The error for the user where a library is not installed; None where this is another error."""
    from pipenav.errors import PipenavError

    if not isinstance(error, ModuleNotFoundError) or error.name is None or error.name.startswith("pipenav"):
        return None
    remedy = "pip install pipenav installs what is missing"
    return PipenavError(f"Python module {error.name!r} is not installed, which this command needs: {remedy}.")


def _fault(error: Exception) -> str:
    """A sentence about an error that no user can cause, with the file that reports it."""
    from pipenav.cli.fault_report import write_report
    from pipenav.errors import shown

    try:
        report = f"a report is in {write_report(error)}; please send it to the maintainers of pipenav"
    except OSError as problem:
        report = f"no report could be written ({problem.strerror})"
    what = ": ".join(filter(None, [type(error).__name__, shown(error, quoted=False)]))
    return f"pipenav failed by a fault of its own, {what}; {report}."


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"pipenav {pipenav.__version__}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Train, evaluate and deploy controllers that take a pipe-inspection robot around sharp pipe corners.

    A first walk: pipenav gen-pipe --d 100 --angle 75, then pipenav train, then pipenav eval --policy runs/arm/best.zip
    """
