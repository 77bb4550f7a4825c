"""Fields of a file of lines, as a person names them, and the diameters that stand there as texts."""

from __future__ import annotations

import re
from typing import Literal, NamedTuple

from pipenav.errors import ConfigError, PipenavError, shown
from pipenav.networks.draft import LineFacts, MapDraft
from pipenav.networks.units import LENGTHS, unit_of

Coordinates = Literal["auto", "m", "ft", "lonlat"]

USUAL_FIELDS = {
    "diameter_mm": "mm",
    "inner_diameter_mm": "mm",
    "diameter_m": "m",
    "diameter_in": "in",
    "bore_mm": "mm",
}
"""Fields that hold a diameter by their names, and its unit."""

TYPE_FIELDS = ("type", "kind", "asset_type", "class")
"""Fields that may say that a line is a service."""

EMPTY = ("", "null", "none", "nan", "n/a", "unknown")
"""Texts that stand for a diameter that nobody knows."""

_WITH_UNIT = re.compile(r"\s*(?:DN|ID)?\s*([-+]?\d*\.?\d+(?:[eE][-+]?\d+)?)\s*(mm|cm|m|in|ft|\")?\s*", re.IGNORECASE)


class DiameterField(NamedTuple):
    """Name of the field that holds diameters, and its unit."""

    name: str
    unit: str

    @classmethod
    def of(cls, text: str) -> DiameterField:
        """The field that `FIELD:mm` names.

        Raises:
            PipenavError: there is no unit, or an unknown one.
        """
        name, colon, unit = text.rpartition(":")
        if not colon or not name:
            raise PipenavError(
                f"--diameter {shown(text, quoted=False)} names no unit: write FIELD:UNIT with one of "
                f"{', '.join(LENGTHS)}, as in bore:mm."
            )
        unit_of(unit)
        return cls(name, unit)


class ReadOptions(NamedTuple):
    """Settings of the readers, for what files do not say themselves.

    Attributes:
        diameter: field of the diameters in files of lines; None to look for usual names.
        snap: distance within which ends of lines are one node [m].
        coordinates: unit of coordinates in files of lines, or `lonlat` for degrees.
        service_bore: bore up to which a line counts as a service [m]; 0 for none.
    """

    diameter: DiameterField | None = None
    snap: float = 0.1
    coordinates: Coordinates = "auto"
    service_bore: float = 0.0


def facts_of(draft: MapDraft, fields: dict[str, object], options: ReadOptions, place: str) -> LineFacts:
    """Facts that the fields of a line state.

    Raises:
        ConfigError: the named field is not there, or no diameter stands in it.
    """
    chosen = options.diameter
    if chosen is None:
        usual = next((name for name in fields if name.lower() in USUAL_FIELDS), None)
        chosen = None if usual is None else DiameterField(usual, USUAL_FIELDS[usual.lower()])
    elif chosen.name not in fields:
        known = ", ".join(list(fields)[:20]) or "none"
        raise draft.refuse(
            place, f"there is no field {shown(chosen.name)} for --diameter; choose one of the fields {known}."
        )
    words = " ".join(str(value) for name, value in fields.items() if name.lower() in TYPE_FIELDS).lower()
    service = "service" in words or "house" in words
    if chosen is None:
        return LineFacts(service=service)
    return LineFacts(diameter=_diameter(draft, fields[chosen.name], chosen.unit, place), service=service)


def _diameter(draft: MapDraft, given: object, unit: str, place: str) -> float | None:
    """A diameter [m], None where the field is empty."""
    text = "" if given is None else str(given).strip()
    if text.lower() in EMPTY:
        return None
    match = _WITH_UNIT.fullmatch(text)
    if match is None:
        raise draft.refuse(place, f"diameter {shown(text)} is not a number: correct it, or leave it empty.")
    own = "in" if match[2] == '"' else (match[2] or unit).lower()
    if own != unit:
        raise ConfigError(
            f"{draft.file}, {place}: diameter {shown(text)} is not in {unit}, the unit that was given: write all of "
            "them in one unit."
        )
    return float(match[1]) * unit_of(unit)
