"""`pipenav survey`: which part of a network a robot can inspect, from where, and what stops it."""

from __future__ import annotations

import math
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.place_options import PlaceOptions
from pipenav.cli.signals import Interrupted
from pipenav.cli.survey_options import MapOptions, ResultOptions, TrialOptions, WayOptions
from pipenav.cli.terminal import progress_console, refuse_ignored, say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from rich.progress import TaskID

    from pipenav.networks.fields import ReadOptions
    from pipenav.networks.model import NetworkMap, Note
    from pipenav.survey.entries import Goal
    from pipenav.survey.findings import Findings, Progress
    from pipenav.survey.survey import Survey, SurveyConfig

FileArgument = Annotated[
    Path, typer.Argument(metavar="FILE", help="A map: EPANET .inp, pandapipes .json, .geojson, .csv, .shp or .pcf.")
]


@takes_option_groups
def survey(
    file: FileArgument,
    map: MapOptions,
    way: WayOptions,
    trial: TrialOptions,
    where: PlaceOptions,
    result: ResultOptions,
) -> None:
    """Find out which part of a pipe network a robot can inspect, from which entry points, and what stops it.

    Every kind of fitting is certified by geometry and simulated once with the policy; both are kept for later surveys,
    also after Ctrl-C. Simulations run in this process, in several (--jobs), or on a Ray cluster (--cluster).

    Examples:

        pipenav survey examples/schutterwald/network.json --check
        pipenav survey examples/schutterwald/network.json
        pipenav survey examples/schutterwald/network.json --jobs 2 --ideal
        pipenav survey my-pipes.geojson --diameter bore:mm --from K12,K40 --cable 500
        pipenav survey my-pipes.shp --diameter DIAM:in --entries 12 --untethered --routes my-routes
    """
    from pipenav.networks.reader import read_network_map
    from pipenav.processes.collector import seldom_collected

    with seldom_collected():  # a map of 100,000 fittings is a million small objects
        network = read_network_map(file, _read_options(map))
        if result.check:
            refuse_ignored({"--routes": result.routes, "--out": result.out}, "--check only reads the map")
            _show_notes(file, network)
            return
        config = _config(map, way)
        _survey(file, network, config, _findings(trial, where), result)


def _read_options(map: MapOptions) -> ReadOptions:
    from pipenav.networks.fields import DiameterField, ReadOptions

    diameter = None if map.diameter is None else DiameterField.of(map.diameter)
    return ReadOptions(diameter, map.snap, map.coordinates, map.service_bore / 1e3)


def _config(map: MapOptions, way: WayOptions) -> SurveyConfig:
    from pipenav.survey.features import Geometry
    from pipenav.survey.passage import Tether
    from pipenav.survey.survey import SurveyConfig

    if way.entry is not None and way.entries is not None:
        raise PipenavError("--entries proposes entries and --from gives them: leave one of them out.")
    tether = Tether(way.cable, way.pull, way.friction, way.cable_weight)
    names = () if way.entry is None else tuple(name.strip() for name in way.entry.split(",") if name.strip())
    if way.entry is not None and not names:
        raise PipenavError("--from names no node: write their names, separated by commas.")
    return SurveyConfig(
        geometry=Geometry(map.accuracy, _bores(map.bends)),
        tether=tether.lifted if way.untethered else tether,
        confidence=way.confidence,
        entries=names,
        goal=_goal(way.entries or "80%"),
    )


def _bores(text: str) -> float:
    """A bend radius in bores from `1.5D`."""
    try:
        value = float(text.removesuffix("D"))
    except ValueError:
        value = math.nan
    if not (value == 0 or (text.endswith("D") and 0.75 <= value <= 100)):
        raise PipenavError(f"--bends {text} is no radius in bores: write 0 for mitres, or 0.75D to 100D.")
    return value


def _goal(text: str) -> Goal:
    from pipenav.survey.entries import MOST_ENTRIES, Goal

    if text.endswith("%"):
        try:
            share = float(text[:-1]) / 100
        except ValueError:
            share = math.nan
        if 0 < share <= 1:
            return Goal(share=share)
    elif text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= MOST_ENTRIES:
        return Goal(number=int(text))
    raise PipenavError(f"--entries {text} is neither a number up to {MOST_ENTRIES} nor a share: write 12 or 80%.")


def _findings(trial: TrialOptions, where: PlaceOptions) -> Findings:
    from pipenav.cli.options import checked_options
    from pipenav.survey.class_store import default_cache
    from pipenav.survey.findings import Findings
    from pipenav.survey.trial_jobs import TrialConfig

    options = checked_options(trial.backend, trial.option or [])
    config = TrialConfig(trial.policy, trial.backend, options, trial.episodes, trial.seed, trial.ideal)
    return Findings(config, trial.cache or default_cache(), where.place())


def _survey(file: Path, network: NetworkMap, config: SurveyConfig, findings: Findings, result: ResultOptions) -> None:
    """Survey a network, write the folder and say what came out."""
    from pipenav.storage.atomic_files import used_folder
    from pipenav.storage.lock import one_writer
    from pipenav.survey.folder import FILES, write_survey
    from pipenav.survey.record import Subject, survey_record
    from pipenav.survey.sensitivity import sensitivities
    from pipenav.survey.survey import survey as survey_of

    out = result.out or Path("runs") / f"survey-{file.stem}"
    with one_writer(out) as folder, ExitStack() as stack:
        if result.routes is not None:  # refused before the work is done
            stack.enter_context(used_folder(result.routes))
        progress = _progress(stack)
        try:
            surveyed = survey_of(network, findings, config, progress)
            rows = sensitivities(surveyed, network, findings, progress)
        except Interrupted:
            say(f"stopped; finished trials are kept in {findings.folder}, and the same command goes on from there")
            raise
        write_survey(folder, survey_record(surveyed, Subject(file.name, findings.trials, rows)))
        stack.close()
    if result.routes is not None:
        _write_routes(surveyed, result.routes)
    _report(surveyed)
    say(f"survey folder {out}: {', '.join(FILES)}")


def _progress(stack: ExitStack) -> Progress:
    """A bar for the trials, which take longest, with words for the rest."""
    from pipenav.cli.progress_bars import percentage_bar

    bar = stack.enter_context(percentage_bar(progress_console()))
    tasks: list[TaskID] = []

    def report(doing: str, done: int, total: int) -> None:
        if not tasks:
            tasks.append(bar.add_task(doing, total=total))
        bar.update(tasks[0], description=doing, completed=done, total=max(total, 1))

    return report


def _report(surveyed: Survey) -> None:
    totals = surveyed.totals
    say(f"mains        {totals.mains / 1e3:8.2f} km, {totals.in_range / 1e3:.2f} km of them in the robot's bores")
    entries = f"{len(surveyed.entries)} {'entry' if len(surveyed.entries) == 1 else 'entries'}"
    say(f"inspectable  {totals.seen / 1e3:8.2f} km from {entries}")
    say(f"unknown      {totals.unknown / 1e3:8.2f} km")
    say(f"blocked      {totals.blocked / 1e3:8.2f} km, or out of the cable's reach")
    proposal = surveyed.proposal
    if proposal is not None and not proposal.reached and proposal.target is not None:
        say(f"no choice of entries sees the {proposal.target / 1e3:.2f} km that were asked for", "yellow")
    costly = {name: more for name, more in surveyed.without.items() if name not in ("unknown", "policy")}
    name = max(costly, key=lambda key: costly[key])
    if costly[name] > totals.seen + 1:
        say(f"the limit that costs most is {name}: without it {(costly[name] - totals.seen) / 1e3:.2f} km more")


def _write_routes(surveyed: Survey, folder: Path) -> None:
    from pipenav.storage.atomic_files import atomic_write_all, prepare_folder
    from pipenav.survey.routes import far_routes

    routes = far_routes(surveyed)
    made = {prepare_folder(folder) / route.name: route.text for route in routes if route.text}
    if made:
        atomic_write_all(made)
    say(f"routes       {len(made)} in {folder}")
    for route in [route for route in routes if not route.text][:5]:
        say(f"             none for {route.name}: {route.problem}", "yellow")


def _show_notes(file: Path, network: NetworkMap) -> None:
    """Show what is doubtful in a map.

    Raises:
        PipenavError: it cannot be surveyed at all.
    """
    from rich.table import Table

    from pipenav.networks.checks import map_notes
    from pipenav.survey.features import Geometry
    from pipenav.survey.graph import mains_graph
    from pipenav.survey.survey import classified, graph_notes

    graph = mains_graph(network)
    notes = [*map_notes(network), *graph_notes(graph)]
    say(
        f"{network.source}: {len(network.line_names)} lines, {len(network.node_names)} nodes, "
        f"{graph.length.sum() / 1e3:.2f} km of mains"
    )
    table = Table("finding", "kind", "number", "examples")
    for note in notes:
        table.add_row(note.text, note.severity, str(note.number), ", ".join(note.examples))
    show(table)
    kinds: dict[str, int] = {}
    for feature in classified(network, graph, Geometry()).features:
        kinds[feature.kind] = kinds.get(feature.kind, 0) + 1
    endings = {kind: "" if n == 1 else "es" if kind == "cross" else "s" for kind, n in kinds.items()}
    words = [f"{n} {kind}{endings[kind]}" for kind, n in sorted(kinds.items())]
    say(f"fittings: {', '.join(words)}")
    _refuse(file, notes)


def _refuse(file: Path, notes: list[Note]) -> None:
    if refused := [note.text for note in notes if note.kind == "no-diameter" and note.severity == "refused"]:
        raise PipenavError(f"{file.name}: {refused[0]}.")
