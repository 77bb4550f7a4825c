"""A stream that is full, slow or closed stops nobody who writes into an outlet."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from typing import TextIO

import pytest
from helpers.waiting import GENEROUS

from pipenav.cli.outlet import MOST_PENDING, Outlet

LINE = "x" * 100 + "\n"


class Pipe:
    """A pipe whose writing end is a text stream."""

    def __init__(self) -> None:
        self.reading, writing = os.pipe()
        self.stream: TextIO = os.fdopen(writing, "w", encoding="utf-8")


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    made = Pipe()
    yield made
    made.stream.close()


def test_what_is_written_comes_out_in_order(pipe: Pipe) -> None:
    outlet = Outlet(pipe.stream)
    for number in range(50):
        assert outlet.write(f"zwölf {number}\n") > 0
    assert outlet.finish(GENEROUS)
    assert os.read(pipe.reading, 65536).decode() == "".join(f"zwölf {number}\n" for number in range(50))


def test_a_stream_without_a_descriptor_is_written_to() -> None:
    stream = io.StringIO()
    outlet = Outlet(stream)
    outlet.write(LINE)
    assert outlet.finish(GENEROUS)
    assert stream.getvalue() == LINE


def test_nobody_waits_for_a_stream_that_is_full(pipe: Pipe) -> None:
    outlet = Outlet(pipe.stream)
    for _ in range(3 * MOST_PENDING):
        outlet.write(LINE)
    assert not outlet.finish(0.0)
    os.close(pipe.reading)
    assert outlet._thread.is_alive() or outlet.finish(GENEROUS)


def test_nobody_hears_of_a_stream_that_is_closed(pipe: Pipe) -> None:
    os.close(pipe.reading)
    outlet = Outlet(pipe.stream)
    for _ in range(50):
        outlet.write(LINE)
    assert outlet.finish(GENEROUS)
