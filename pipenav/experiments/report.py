"""`report.md` and `report.html`: each table of the thesis beside ours, the pictures, and whether its findings held."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pipenav.drawing.style import png
from pipenav.experiments.definition import agents_of, load_experiment
from pipenav.experiments.figures import success_figure, training_figure
from pipenav.experiments.findings import paragraph
from pipenav.experiments.html_report import STAGE_LABELS, Section, experiments_page
from pipenav.experiments.plan import TRAINED_FILE, ExperimentPlan, elapsed, is_complete, read_number
from pipenav.experiments.tables import Line, Result, results
from pipenav.storage.atomic_files import Content, atomic_write, atomic_write_all

INTRODUCTION = (
    "Success in percent, mean over the corner angles of one diameter (55 to 125 deg in steps of 5). Ours is the mean"
    " over the seeds, with the lowest and highest seed in brackets where they differ; the thesis gives one figure each."
    " Success of `rear` is a share of the episodes in which `reach` succeeded; `whole` is every stage together,"
    " over all episodes."
)


def write_report(plan: ExperimentPlan) -> list[str]:
    """Write the report of what the plan's folder holds; returns the names of its files.

    Args:
        plan: a plan whose experiments are complete.
    """
    sections = [_with_pictures(plan, _section(plan, name)) for name in plan.experiments]
    summary = _summary(plan)
    pictures = {name: content for section in sections for name, content in section.pictures.items()}
    files: dict[str, Content] = {
        **pictures,
        "report.md": _markdown(sections, summary),
        "report.html": experiments_page(plan, sections, _introduction(summary)),
    }
    atomic_write_all({plan.out / name: content for name, content in files.items()})
    return list(files)


def write_unfinished_report(plan: ExperimentPlan) -> list[str]:
    """Write the page of the experiments that are complete, without pictures, which take time to draw.

    Returns:
        Names of these experiments; where there are none, nothing is written.
    """
    complete = [name for name in plan.experiments if is_complete(plan, name)]
    if complete:
        part = plan._replace(experiments=tuple(complete))
        sections = [_section(part, name) for name in complete]
        atomic_write(plan.out / "report.html", experiments_page(part, sections, _introduction(_summary(part))))
    return complete


def _introduction(summary: str) -> str:
    return f"{INTRODUCTION} {summary}".replace("`", "")


def _section(plan: ExperimentPlan, name: str) -> Section:
    found, experiment = results(plan, name), load_experiment(name)
    return Section(name, f"({name}) {experiment.title}", experiment.question, paragraph(name, found), found, {})


def _with_pictures(plan: ExperimentPlan, section: Section) -> Section:
    name, found = section.name, section.results
    pictures = {f"{name}-success.png": png(success_figure(found, section.title))}
    if (training := training_figure(plan, found, section.title)) is not None:
        pictures = {f"{name}-training.png": png(training), **pictures}
    return section._replace(pictures=pictures)


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


def _markdown(sections: Sequence[Section], summary: str) -> str:
    parts = ["# The thesis's experiments", INTRODUCTION, summary]
    for section in sections:
        headings, rows = _table(section.results)
        lines = [f"| {' | '.join(row)} |" for row in (headings, ["---"] * len(headings), *rows)]
        pictures = [f"![{name.removesuffix('.png')}]({name})" for name in section.pictures]
        parts += [f"## {section.title}", section.question, "\n".join(lines), section.paragraph, *pictures]
        if recipes := section.recipes:
            parts.append(f"```\n{recipes}\n```")
    return "\n\n".join(parts) + "\n"
