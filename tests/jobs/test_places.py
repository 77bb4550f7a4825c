"""Places are found as distributions declare them, and what a person typed for them is checked."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from pipenav.errors import PipenavError, UnknownName
from pipenav.jobs import Place, chosen_place, load_place, places
from pipenav.jobs.here import HerePlace
from pipenav.jobs.processes import ProcessesPlace

DECLARED = {
    "processes": ["pipenav.jobs.processes:ProcessesPlace"],
    "twice": ["one:Place", "other:Place"],
    "broken": ["no_such_module_of_anybody:Place"],
    "strange": ["pathlib:Path"],
    "ray": ["no_such_module_of_anybody:Place"],
}


@pytest.fixture(autouse=True)
def declared(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [EntryPoint(name, value, places.GROUP) for name, values in DECLARED.items() for value in values]
    monkeypatch.setattr(places, "entry_points", lambda group: points if group == places.GROUP else [])


def test_a_place_is_chosen_by_its_option() -> None:
    assert isinstance(chosen_place(None, None), HerePlace)
    place = chosen_place(3, None)
    assert isinstance(place, ProcessesPlace)
    assert (place.processes, place.name) == (3, "3 processes")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("prosesses", "did you mean 'processes'"),
        ("twice", "declared twice"),
        ("broken", "install what it needs"),
        ("ray", r"pip install 'pipenav\[ray\]'"),
        ("strange", "is no subclass"),
    ],
)
def test_what_is_no_place_is_said_with_advice(name: str, message: str) -> None:
    with pytest.raises(PipenavError, match=message):
        load_place(name)


def test_an_unknown_place_is_an_unknown_name() -> None:
    with pytest.raises(UnknownName):
        load_place("elsewhere")


@pytest.mark.parametrize("given", ["0", "-1", "two", "1025", "1.5", "", "٣"])
def test_numbers_of_processes_are_checked(given: str) -> None:
    with pytest.raises(PipenavError, match="choose 1 to 1024"):
        ProcessesPlace(given)


def test_two_places_at_once_are_refused() -> None:
    with pytest.raises(PipenavError, match="give one of them"):
        chosen_place(2, "auto")


def test_every_place_of_ours_is_one() -> None:
    assert issubclass(HerePlace, Place) and issubclass(ProcessesPlace, Place)
