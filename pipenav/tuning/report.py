"""The report of a search: table and pictures of its trials, the best settings, and whether they beat the preset's."""

from __future__ import annotations

import csv
import io
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pipenav.drawing.style import png
from pipenav.storage.atomic_files import Content, atomic_write_all
from pipenav.tuning.figures import history_figure, importance_figure
from pipenav.tuning.objective import Objective, Outcome
from pipenav.tuning.plan import TunePlan
from pipenav.tuning.recipe import recipe_text
from pipenav.tuning.search import PRESET, Search, trial_name
from pipenav.tuning.space import value_text
from pipenav.tuning.study import TrialRecord

BEST_FILE, REPORT_FILE, TABLE_FILE = "best.toml", "report.md", "trials.csv"
HISTORY_FILE, IMPORTANCE_FILE = "history.png", "importance.png"

STATE_WORDS = {"done": "done", "pruned": "ended early", "running": "not done yet", "refused": "fits no training"}


class TrialRow(NamedTuple):
    """A row of the table of trials, as texts.

    Attributes:
        name: number of the trial, or `preset`.
        value: its objective in words.
        success: success of its best check [%].
        steps, seconds: control steps and seconds that it trained.
        state: how it ended.
        settings: its settings in the order of the space.
    """

    name: str
    value: str
    success: str
    steps: str
    seconds: str
    state: str
    settings: tuple[str, ...]


def trial_rows(search: Search) -> list[TrialRow]:
    """The preset and all trials, the best first."""
    objective, keys = search.plan.objective, list(search.plan.space.space)
    rows = []
    if (preset := search.preset()) is not None:
        known = search.plan.preset_settings() or {}
        rows.append(_row(PRESET, "done", preset, objective, [_text(known.get(key)) for key in keys]))
    for record in sorted(search.study.records(), key=lambda record: _rank(record, objective)):
        if not record.preset:
            settings = [_text(record.settings.get(key)) for key in keys]
            rows.append(_row(str(record.number), record.state, record.outcome, objective, settings))
    return rows


def _rank(record: TrialRecord, objective: Objective) -> tuple[int, float]:
    value = 0.0 if record.outcome is None else objective.value(record.outcome)
    return ["done", "pruned", "running", "refused"].index(record.state), value


def _row(name: str, state: str, outcome: Outcome | None, objective: Objective, settings: list[str]) -> TrialRow:
    if outcome is None:
        return TrialRow(name, "", "", "", "", STATE_WORDS[state], tuple(settings))
    value = objective.words(objective.value(outcome)) if state == "done" else ""
    success, steps, seconds = f"{100 * outcome.success:.1f}", str(outcome.steps), f"{outcome.seconds:.1f}"
    return TrialRow(name, value, success, steps, seconds, STATE_WORDS[state], tuple(settings))


def _text(value: object) -> str:
    return "" if value is None else value if isinstance(value, str) else value_text(value)


def write_report(search: Search) -> list[Path]:
    """Write the report of what a search has found so far; returns its files."""
    objective, records = search.plan.objective, search.study.records()
    rows, best, importance = trial_rows(search), search.best(), search.study.importance()
    files: dict[str, Content] = {
        TABLE_FILE: _csv(search, rows),
        HISTORY_FILE: png(history_figure(records, objective, search.preset())),
        IMPORTANCE_FILE: png(importance_figure(importance, objective)),
        REPORT_FILE: _markdown(search, rows, importance),
    }
    if best is not None:
        files[BEST_FILE] = recipe_text(search.plan, best, verdict(search))
    atomic_write_all({search.plan.out / name: content for name, content in files.items()})
    return [search.plan.out / name for name in files]


def verdict(search: Search) -> str:
    """Sentences that say whether the best settings beat the preset's."""
    objective, best, preset = search.plan.objective, search.best(), search.preset()
    if best is None or best.outcome is None or preset is None:
        return "No trial is done yet."
    mine, theirs = objective.value(best.outcome), objective.value(preset)
    found = (
        f"Best of the search: trial {best.number}, {objective.words(mine)}; the preset with the same seed: "
        f"{objective.words(theirs)}."
    )
    if mine >= theirs:
        return f"{found} No trial beats the preset."
    ours, others = search.repeated(trial_name(best.number)), search.repeated(PRESET)
    if not ours or len(ours) != len(others):
        return f"{found} That is one seed, and the best of many: train both with other seeds before you believe it."
    here, there = ([objective.value(outcome) for outcome in outcomes] for outcomes in (ours, others))
    seeds, wins = ", ".join(map(str, search.other_seeds)), sum(a < b for a, b in zip(here, there, strict=True))
    compared = (
        f"With other seeds ({seeds}): {_list(objective, here)}; the preset: {_list(objective, there)}. "
        f"Better in {wins} of {len(here)}"
    )
    return f"{found} {compared}: the trial {'beats' if 2 * wins > len(here) else 'does not beat'} the preset."


def _list(objective: Objective, values: Sequence[float]) -> str:
    return ", ".join(map(objective.words, values))


def _introduction(plan: TunePlan) -> str:
    early = " A trial ended at its first success." if plan.objective.ends_early else ""
    return (
        f"Objective: {plan.objective.title}. Trainings of {plan.config.steps:,} steps, preset `{plan.base.preset}`, "
        f"with seed {plan.config.seed}.{early} One whose checks were worse than the median trial's ended early."
    )


def _csv(search: Search, rows: Sequence[TrialRow]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["trial", "objective", "success_percent", "steps", "seconds", "state", *search.plan.space.space])
    writer.writerows([*row[:-1], *row.settings] for row in rows)
    return text.getvalue()


def _markdown(search: Search, rows: Sequence[TrialRow], importance: dict[str, float]) -> str:
    plan, problems = search.plan, [record for record in search.study.records() if record.problem]
    headings = ["trial", plan.objective.title, "success [%]", "steps", "seconds", "", *plan.space.space]
    trained = [[*row[:-1], *row.settings] for row in rows if row.state != STATE_WORDS["refused"]]
    table = "\n".join(f"| {' | '.join(row)} |" for row in (headings, ["---"] * len(headings), *trained))
    shares = ", ".join(f"{key} {share:.0%}" for key, share in importance.items())
    train = shlex.join(["pipenav", "train", "--config", str(plan.out / BEST_FILE)])
    parts = [
        f"# Search: {plan.space.description}",
        _introduction(plan),
        verdict(search),
        f"![history]({HISTORY_FILE})",
        f"![importance]({IMPORTANCE_FILE})",
        f"Importance: {shares or 'too few trials are done to tell'}.",
        table,
        *([f"{len(problems)} suggestions fitted no training; the last: {problems[-1].problem}"] if problems else []),
        *([f"Train with the best settings:\n\n```sh\n{train}\n```"] if search.best() is not None else []),
    ]
    return "\n\n".join(parts) + "\n"
