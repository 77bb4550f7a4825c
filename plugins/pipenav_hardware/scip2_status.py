"""The status of a SCIP2 reply, two characters, in words (specification C-42-03320B)."""

from __future__ import annotations

OK, SCAN, RESUMED = "00", "99", "98"

COMMON = {
    "0A": "it cannot carry out the command",
    "0B": "its buffer is full, or it is carrying out the command already",
    "0C": "the command lacks a parameter",
    "0D": "the command lacks a parameter",
    "0E": "it does not know the command",
    "0F": "it does not know the command",
    "0G": "the command is too short",
    "0H": "the command's text is too long",
    "0I": "the command's text has a wrong character",
    "0J": "its firmware is being updated",
}
"""Status of any command."""

SPECIAL = {
    "BM": {"01": "its laser cannot be switched on: it has a malfunction"},
    "MD": {
        "01": "the first step is not a number", "02": "the last step is not a number",
        "03": "the cluster is not a number", "04": "the last step is beyond its fan",
        "05": "the last step is before the first", "06": "the interval is not a number",
        "07": "the count is not a number",
    },
    "TM": {"01": "it does not know the control code"},
}  # fmt: skip
"""Status of one command, by the command's first two characters."""

HARMLESS = {"BM": ("02",), "TM": ("02", "03", "04")}
"""Status that says that there was nothing to do: the laser is on already, the time-stamp mode is on or off already."""


def accepted(command: str, status: str) -> bool:
    """Whether a command was carried out, or had nothing to do."""
    return status in (OK, *HARMLESS.get(command[:2], ()))


def words(command: str, status: str) -> str:
    """The status of a reply in words."""
    meaning = SPECIAL.get(command[:2], {}).get(status) or COMMON.get(status)
    if meaning is None and status.isdigit():
        if 21 <= int(status) <= 49:
            meaning = "it stopped to look into an error"
        elif 50 <= int(status) <= 97:
            meaning = "its hardware is in trouble: laser, motor or circuit"
    return f"says status {status}" + (f": {meaning}" if meaning else "")
