"""Sensitivity of the inspected length to what nobody knows exactly: the map's error, the cable, friction, rates."""

from __future__ import annotations

import math
from typing import NamedTuple

from pipenav.networks.model import NetworkMap
from pipenav.survey.findings import Findings, Progress
from pipenav.survey.passage import Judged, Tether, Ways, cost_of, geometry_accuracy, judgements_of, ways_of
from pipenav.survey.reach import search
from pipenav.survey.survey import Survey, classified

FACTORS = (0.5, 2.0)
"""Factors by which each number is made smaller and larger."""


class Sensitivity(NamedTuple):
    """Inspected length with one number changed, from the same entries.

    Attributes:
        what: name of the number.
        unit: its unit.
        low, value, high: the number as it is made smaller, as it is, and larger.
        seen_low, seen, seen_high: inspected lengths with these [m].
    """

    what: str
    unit: str
    low: float
    value: float
    high: float
    seen_low: float
    seen: float
    seen_high: float


def sensitivities(
    result: Survey, network: NetworkMap, findings: Findings, progress: Progress | None = None
) -> list[Sensitivity]:
    """A row for each number; classes that only a larger map error brings in are tried too."""
    rows = []
    tether = result.config.tether
    if math.isfinite(tether.cable):
        for what, unit in (("cable", "m"), ("pull", "N"), ("friction", ""), ("weight", "N/m")):
            value = float(getattr(tether, what))
            low, high = (value * factor for factor in FACTORS)
            seen = [_seen(result, result.ways, tether._replace(**{what: changed})) for changed in (low, high)]
            rows.append(Sensitivity(what, unit, low, value, high, seen[0], result.totals.seen, seen[1]))
    if not network.fabricated:
        rows.append(_accuracy(result, network, findings, progress))
    rows.append(_rates(result))
    return rows


def _seen(result: Survey, ways: Ways, tether: Tether) -> float:
    reach = search(ways, tether, result.config.confidence, result.entries)
    return float(reach.seen(result.graph.length).sum())


def _accuracy(result: Survey, network: NetworkMap, findings: Findings, progress: Progress | None) -> Sensitivity:
    geometry, seen = result.config.geometry, []
    for factor in FACTORS:
        changed = geometry._replace(accuracy=geometry.accuracy * factor)
        fittings = classified(network, result.graph, changed)
        classes = {kind for movement in fittings.movements for kind in movement.classes}
        judgements = judgements_of(fittings.movements, findings.of(classes, progress), result.config.confidence)
        ways = ways_of(
            fittings, judgements, findings.trained, findings.robot, geometry_accuracy(changed, network.fabricated)
        )
        seen.append(_seen(result, ways, result.config.tether))
    low, high = (geometry.accuracy * factor for factor in FACTORS)
    return Sensitivity("accuracy", "m", low, geometry.accuracy, high, seen[0], result.totals.seen, seen[1])


def _rates(result: Survey) -> Sensitivity:
    """The row of the rates of passing: at the low ends of their intervals, as counted, and all of them 1."""

    def changed(to_low: bool) -> Ways:
        def cost(judgement: Judged) -> float:
            return cost_of(judgement.low if to_low else 1.0, judgement.verdict)

        return result.ways._replace(cost=[cost(judgement) for judgement in result.judgements])

    tether = result.config.tether
    seen = [_seen(result, changed(to_low), tether) for to_low in (True, False)]
    tried = [
        finding.trial for finding in result.findings.values() if finding.trial.episodes and not finding.trial.assumed
    ]
    episodes = sum(trial.episodes for trial in tried)
    rate = sum(trial.successes for trial in tried) / episodes if episodes else math.nan
    low = min((trial.interval.low for trial in tried if trial.successes == trial.episodes), default=math.nan)
    return Sensitivity("rates of passing", "", low, rate, 1.0, seen[0], result.totals.seen, seen[1])
