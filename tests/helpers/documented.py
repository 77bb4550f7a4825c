"""Documented commands as tests run them: with sizes that take a second, or not at all where they need an arm.

A command that no rule here knows is refused, so that a new one in the docs gets its rule.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import pytest

from pipenav.cli import main

Words = tuple[str, ...]

DROPPED = {"--out", "--episodes", "--seed", "--steps", "--seeds", "--jobs", "--cluster", "--shard"}
"""Options that change nothing of what a test looks at: commands that differ in them alone are run once."""

CORNERS = {
    "working-range": "d=100,angle=90",
    "thesis": "d=100,angle=90",
    "thesis-real": "d=130,angle=90",
    "elbows": "d=100,angle=90,bend_radius=1.5D",
    "tees": "d=100,tee=90,way=into",
    "frontier-pirate": "d=70,angle=90",
    "frontier-basic": "d=70,angle=90",
    "frontier-real-setup": "d=70,angle=90",
    "frontier-high-fidelity": "d=70,angle=90",
}
"""Corners that stand for sets of many."""

ROUTES = {
    "runs-level": "my-route.toml",
    "runs-rolled": "my-rolled-route.toml",
    "s-bends": "s-bends:1",
    "reducers": "reducers:1",
    "town": "town-train:1",
    "space-elbows": "space-train:1",
    "space-tees": "space-train:1",
    "space-reducers": "space-train:1",
    "space-s-bends": "space-train:1",
    "space-town": "space-train:1",
}
"""A short route in place of a set."""

TRAINING = (
    "learner.robots=4",
    "learner.rollout_steps=8",
    "learner.batch_size=8",
    "learner.epochs=1",
    "check.episodes=2",
    "check.every=64",
)
"""Settings of a training that takes a second."""


class Expected(NamedTuple):
    """Expected end of a command: its exit code, and words that it says."""

    code: int = 0
    words: str = ""


REFUSED = {
    "calibrate": Expected(1, "/dev/ttyUSB0"),
    "hw-check": Expected(1, "arm.toml"),
    "run-real": Expected(1, "arm.toml"),
}
"""Commands that need an arm: without one they say in one sentence what is missing."""


class Options(NamedTuple):
    """A command's options, in order, and what stands before them.

    Attributes:
        command: the subcommand.
        arguments: words that belong to no option.
        given: pairs of an option and its value; None of a flag.
    """

    command: str
    arguments: Words
    given: tuple[tuple[str, str | None], ...]

    @classmethod
    def of(cls, argv: Words) -> Options:
        """The parts of `pipenav COMMAND ...`."""
        arguments: list[str] = []
        given: list[tuple[str, str | None]] = []
        for word in argv[2:]:
            if word.startswith("--"):
                given.append((word, None))
            elif given and given[-1][1] is None and given[-1][0] not in FLAGS:
                given[-1] = (given[-1][0], word)
            else:
                arguments.append(word)
        return cls(argv[1], tuple(arguments), tuple(given))

    def without(self, names: Iterable[str]) -> Options:
        return self._replace(given=tuple(pair for pair in self.given if pair[0] not in names))

    def plus(self, *pairs: tuple[str, str | None]) -> Options:
        return self._replace(given=(*self.given, *pairs))

    def value(self, name: str) -> str | None:
        """The last value of an option."""
        return next((value for option, value in reversed(self.given) if option == name), None)

    def has(self, name: str) -> bool:
        return any(option == name for option, _ in self.given)

    @property
    def argv(self) -> Words:
        """Words that follow `pipenav` on the command line."""
        words = [word for option, value in self.given for word in (option, value) if word is not None]
        return (self.command, *self.arguments, *words)


FLAGS = {
    "--allow-slow-bus",
    "--certify",
    "--check",
    "--dry-run",
    "--emulate",
    "--help",
    "--live",
    "--replay",
    "--untethered",
    "--write-servos",
    "--yes",
}


def pipenav(*words: str) -> int:
    """Exit code of `pipenav WORDS`, in this process."""
    with pytest.raises(SystemExit) as left:
        main(words)
    assert left.value.code is None or isinstance(left.value.code, int)
    return left.value.code or 0


def tiny(argv: Words) -> Words:
    """Small command that a test runs in place of `pipenav ...`.

    Raises:
        KeyError: a command that has no rule.
    """
    options = Options.of(argv)
    return RULES[options.command](options).argv


def expected(argv: Words) -> Expected:
    """Expected end of the tiny command."""
    if argv[0] == "run-real" and "--emulate" in argv:
        return Expected(0, "5 ticks")
    if argv[0] == "drive" and "--arm" in argv:
        return Expected(1, "stdin is none")
    if argv[0] == "drive" and "--emulate" in argv:
        return Expected(0, "ended: 5 ticks")
    if "lag" in argv and argv[0] == "compare-backends":
        return Expected(1, "too large")
    return REFUSED.get(argv[0], Expected())


def _as_it_stands(options: Options) -> Options:
    return options


def _train(options: Options) -> Options:
    if options.has("--resume"):
        return options.plus(("--steps", "128"))
    given = {value.partition("=")[0] for option, value in options.given if option == "--set" and value}
    settings = [("--set", setting) for setting in TRAINING if setting.partition("=")[0] not in given]
    return options.without({*DROPPED, "--from-recordings"}).plus(("--steps", "64"), *settings, ("--out", "trained"))


def _eval(options: Options) -> Options:
    if options.has("--starts"):  # these name their pipes
        return options.without(DROPPED).plus(("--out", "evaluated"))
    pipes = [value for option, value in options.given if option == "--pipes"] or ["working-range"]
    route = "pirate" in str(options.value("--policy"))
    first = (ROUTES if route else {}).get(str(pipes[0]), CORNERS.get(str(pipes[0]), str(pipes[0])))
    rest = sorted(options.without({*DROPPED, "--pipes"}).given, key=lambda pair: (pair[0], pair[1] or ""))
    small = [("--pipes", first), ("--episodes", "1"), ("--out", "evaluated")]
    return options._replace(given=(*rest, *small))


def _view(options: Options) -> Options:
    """The same motion as a strip instead of a film; the film of the policy `arm` stays one.

    An evaluation's folder is the workshop's, whose only episode has number 0.
    """
    if options.has("--eval"):
        return options.without(("--eval", "--episode")).plus(("--eval", "evaluation"), ("--episode", "0"))
    strips = options.value("--policy") != "arm"

    def smaller(name: str, value: str | None) -> tuple[str, str | None]:
        if name == "--out" and strips and value is not None:
            return name, value.replace(".gif", ".png")
        return name, ROUTES.get(str(value).partition(":")[0], value) if name == "--pipes" else value

    return options._replace(given=tuple(smaller(*pair) for pair in options.given))


def _experiment(options: Options) -> Options:
    """The one without a training, for every stage of `all` takes the same way."""
    small = (("--seeds", "1"), ("--episodes", "1"), ("--jobs", "1"))
    return options._replace(arguments=("e",)).without(DROPPED).plus(*small, ("--out", "reported"))


def _export(options: Options) -> Options:
    """A few observations of one corner to compare on."""
    small = (("--observations", "50"), ("--pipes", "d=100,angle=90"))
    return options.without(("--observations", "--pipes")).plus(*small)


def _tune(options: Options) -> Options:
    """A search of two trials in one corner, each as short as a documented training."""
    settings = [("--set", setting) for setting in (*TRAINING, 'pipes=["d=100,angle=90"]', "task.max_steps=10")]
    small = (("--space", "my-space.toml"), ("--trials", "2"), ("--again", "0"), ("--objective", "success"))
    return options._replace(given=(*small, ("--steps", "64"), *settings, ("--out", "searched")))


def _run_real(options: Options) -> Options:
    if not options.has("--emulate"):
        return options
    return options.plus(("--ticks", "5"), ("--patience", "10"))


def _drive(options: Options) -> Options:
    """A single episode in one corner, by a script where a person would drive."""
    if options.has("--emulate"):
        given = (("--ticks", "5"), ("--patience", "10"), ("--operator", "scripted"), ("--allow-slow-bus", None))
        return options.plus(*given)
    if options.has("--arm"):
        return options
    names = {"--operator", "--pipes", "--episodes", "--out", "--watch", "--input", "--device"}
    kept = tuple(pair for pair in options.given if pair[0] not in names)
    alone = options.value("--operator") == "none"
    small = (("--operator", "none" if alone else "scripted"), ("--pipes", "d=100,angle=90"))
    return options._replace(given=(*kept, *small))


def _survey(options: Options) -> Options:
    """The example's map is read and checked; trials would take minutes."""
    example = str(Path(__file__).resolve().parents[2] / "examples/schutterwald/network.json")
    return options._replace(arguments=(example,)).without(("--routes", "--out", "--check")).plus(("--check", None))


RULES: dict[str, Callable[[Options], Options]] = {
    "backends": _as_it_stands,
    "calibrate": _as_it_stands,
    "certify": _as_it_stands,
    "compare": _as_it_stands,
    "compare-backends": _as_it_stands,
    "drive": _drive,
    "eval": _eval,
    "experiment": _experiment,
    "export": _export,
    "gen-pipe": _as_it_stands,
    "hw-check": _as_it_stands,
    "list": _as_it_stands,
    "locate-target": _as_it_stands,
    "mirror-rear": _as_it_stands,
    "presets": _as_it_stands,
    "replay": _as_it_stands,
    "robots": _as_it_stands,
    "run-real": _run_real,
    "survey": _survey,
    "train": _train,
    "tune": _tune,
    "view": _view,
}
