"""Words for evaluations in pictures and tables: subject, circumstances, percentages, names of routes."""

from __future__ import annotations

from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.results import Evaluation

SHOWN_CORNERS = 5
"""Corners of a route that are written out."""


def headline(evaluation: Evaluation) -> str:
    """Subject and success of an evaluation, in one line."""
    low, high = evaluation.success_low, evaluation.success_high
    return (
        f"{evaluation.policy}: {percent(evaluation.success)} % of {evaluation.episodes:,} episodes "
        f"(95 % interval {percent(low)}–{percent(high)})"
    )


def circumstances(evaluation: Evaluation) -> str:
    """Circumstances of an evaluation in two lines: what was run, then backend, settings, disturbances and seed."""
    config, pipes = evaluation.config, len(evaluation.pipes)
    more = f" and {len(config.pipes) - 1} more" if len(config.pipes) > 1 else ""
    located = f", variant {config.variant}" if evaluation.stage in ("locate", "passage") else ""
    more += "" if config.tether is None else f", cable of {config.tether:g} m"
    more += "" if config.max_force is None else f", at most {config.max_force:g} N"
    more += "" if config.starts is None else f", {config.starts}"
    more += "" if config.sensors is None else f", {config.sensors} sensors"
    more += ", recovery" if config.recover else ""
    settings = ", ".join(f"{name} {value}" for name, value in evaluation.options.items())
    return (
        f"stage {evaluation.stage}{located}, {pipes} pipe{'s' if pipes > 1 else ''} × {evaluation.episodes_per_pipe} "
        f"episodes, {config.pipes[0]}{more}, {evaluation.robot} robot\n"
        f"backend {evaluation.backend} ({settings or 'default settings'}), "
        f"disturbances {evaluation.disturb or 'none'}, seed {evaluation.seed}"
    )


def percent(share: float, decimals: int = 1) -> str:
    """A share in percent; it reads 100 and 0 only where nothing, or everything, failed."""
    if share in (0.0, 1.0):
        return f"{share * 100:.0f}"
    least = 10.0**-decimals
    return f"{min(max(share * 100, least), 100 - least):.{decimals}f}"


def route_corners(record: PipeRecord) -> str:
    """The first corners of a route, as its name has them."""
    corners = (record.route or "").split("-")[2:]
    return "-".join([*corners[:SHOWN_CORNERS], *(["..."] if len(corners) > SHOWN_CORNERS else [])])
