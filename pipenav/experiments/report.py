"""`report.md` and `report.html`: each table of the thesis beside ours, the pictures, and whether its findings held."""

from __future__ import annotations

import base64
import html
import shlex
from collections.abc import Sequence
from typing import NamedTuple

from pipenav.drawing.style import png
from pipenav.experiments.definition import agents_of, load_agents, load_experiment
from pipenav.experiments.figures import success_figure, training_figure
from pipenav.experiments.findings import paragraph
from pipenav.experiments.plan import TRAINED_FILE, ExperimentPlan, elapsed, read_number
from pipenav.experiments.tables import Line, Result, results
from pipenav.storage.atomic_files import Content, atomic_write_all

INTRODUCTION = (
    "Success in percent, mean over the corner angles of one diameter (55 to 125 deg in steps of 5). Ours is the mean"
    " over the seeds, with the lowest and highest seed in brackets where they differ; the thesis gives one figure each."
    " Success of `rear` is a share of the episodes in which `reach` succeeded; `whole` is every stage together,"
    " over all episodes."
)

STAGE_LABELS = {"locate": "locate", "reach": "reach", "rear": "rear", "whole": "whole passage"}

STYLE = (
    "body{font:16px/1.5 system-ui,sans-serif;color:#20262c;max-width:70rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;margin:1rem 0}"
    "td,th{padding:.3rem .7rem;border-bottom:1px solid #e3e7eb;text-align:left}"
    "img{max-width:100%;height:auto}h2{margin-top:3rem}"
)


class Section(NamedTuple):
    """An experiment in the report; pictures are PNG files' contents by name."""

    name: str
    title: str
    question: str
    paragraph: str
    results: list[Result]
    pictures: dict[str, bytes]


def write_report(plan: ExperimentPlan) -> list[str]:
    """Write the report of what the plan's folder holds; returns the names of its files.

    Args:
        plan: a plan whose experiments are complete.
    """
    sections = [_section(plan, name) for name in plan.experiments]
    summary = _summary(plan)
    pictures = {name: content for section in sections for name, content in section.pictures.items()}
    files: dict[str, Content] = {
        **pictures,
        "report.md": _markdown(sections, summary),
        "report.html": _html(sections, summary),
    }
    atomic_write_all({plan.out / name: content for name, content in files.items()})
    return list(files)


def _section(plan: ExperimentPlan, name: str) -> Section:
    found, experiment = results(plan, name), load_experiment(name)
    title = f"({name}) {experiment.title}"
    pictures = {f"{name}-success.png": png(success_figure(found, title))}
    if (training := training_figure(plan, found, title)) is not None:
        pictures = {f"{name}-training.png": png(training), **pictures}
    return Section(name, title, experiment.question, paragraph(name, found), found, pictures)


def _summary(plan: ExperimentPlan) -> str:
    """Trainings and episodes, and how long they took against the time that the robots lived through."""
    folders = [plan.training_folder(agent, seed) for agent in agents_of(list(plan.experiments)) for seed in plan.seeds]
    steps = sum(int(read_number(folder / TRAINED_FILE, "steps")) for folder in folders)
    hours = steps / 10 / 3600
    episodes = sum(r.episodes for name in plan.experiments for r in results(plan, name))
    text = (
        f"Experiments {', '.join(plan.experiments)}; {len(folders)} trainings (seeds"
        f" {', '.join(map(str, plan.seeds))}) of {steps:,} control steps in all, which is {hours:,.0f} h of the robots'"
        f" time; {episodes:,} episodes of evaluation in the tables, {plan.settings.episodes} per pipe and agent,"
        f" backend {plan.settings.backend}."
    )
    seconds = elapsed(plan)
    if seconds > 0:
        text += (
            f" All of it took {seconds / 60:.1f} min: {hours * 3600 / seconds:,.0f} times faster than the robots' time."
        )
    return text


class _Table(NamedTuple):
    headings: list[str]
    rows: list[list[str]]


def _table(results: Sequence[Result]) -> _Table:
    """An experiment's table, as texts."""
    lines = [line for result in results for line in result.lines]
    diameters = sorted({d for line in lines for d in line.ours}, reverse=True)
    headings = ["agent", "stage", "", *(f"{d:g} mm" for d in diameters)]
    rows = []
    for line in lines:
        ours = [line.ours[d].text if d in line.ours else "-" for d in diameters]
        rows.append([line.label, STAGE_LABELS[line.stage], "ours", *ours])
        if line.thesis:
            rows.append(["", "", f"thesis, table {line.table}", *(_number(line, d) for d in diameters)])
    return _Table(headings, rows)


def _number(line: Line, diameter: float) -> str:
    return f"{line.thesis[diameter]:g}" if diameter in line.thesis else "-"


def _settings(section: Section) -> str:
    """The recipe of each agent of a section, in words that `pipenav train` takes."""
    parts = []
    for agent in dict.fromkeys(result.row.agent for result in section.results):
        if agent in load_agents():
            recipe = load_agents()[agent]
            settings = "".join(f" --set {shlex.quote(f'{key}={value}')}" for key, value in recipe.settings.items())
            parts.append(f"{agent}: pipenav train --preset {recipe.preset}{settings}")
    return "\n".join(parts)


def _markdown(sections: Sequence[Section], summary: str) -> str:
    parts = ["# The thesis's experiments", INTRODUCTION, summary]
    for section in sections:
        headings, rows = _table(section.results)
        lines = [f"| {' | '.join(row)} |" for row in (headings, ["---"] * len(headings), *rows)]
        pictures = [f"![{name.removesuffix('.png')}]({name})" for name in section.pictures]
        parts += [f"## {section.title}", section.question, "\n".join(lines), section.paragraph, *pictures]
        if recipes := _settings(section):
            parts.append(f"```\n{recipes}\n```")
    return "\n\n".join(parts) + "\n"


def _html(sections: Sequence[Section], summary: str) -> str:
    """The report as one file that holds its pictures."""
    body = ["<h1>The thesis's experiments</h1>", _p(INTRODUCTION), _p(summary)]
    for section in sections:
        headings, rows = _table(section.results)
        head = "".join(f"<th>{html.escape(cell)}</th>" for cell in headings)
        cells = ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
        lines = "".join(f"<tr>{row}</tr>" for row in (head, *cells))
        body += [f"<h2>{html.escape(section.title)}</h2>", _p(section.question), f"<table>{lines}</table>"]
        body.append(_p(section.paragraph))
        for name, content in section.pictures.items():
            data = base64.b64encode(content).decode("ascii")
            body.append(f'<p><img alt="{html.escape(name)}" src="data:image/png;base64,{data}"></p>')
        if recipes := _settings(section):
            body.append(f"<pre>{html.escape(recipes)}</pre>")
    head = f'<meta charset="utf-8"><title>The thesis\'s experiments</title><style>{STYLE}</style>'
    return f'<!doctype html><html lang="en"><head>{head}</head><body>{"".join(body)}</body></html>\n'


def _p(text: str) -> str:
    return f"<p>{html.escape(text)}</p>"
