"""Pipes with tees, crosses and caps as JSON: what is read is what was written."""

from __future__ import annotations

import json

import pytest
from helpers.random_networks import random_routes
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from pipenav.export.route_folder import read_route_folder, route_record
from pipenav.pipes.json_keys import PipeInFile, keys_of_pipe
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.tee import TeePassage, tee

ADAPTER: TypeAdapter[object] = TypeAdapter(PipeInFile)

seeds = st.integers(0, 2**31 - 1)


@given(seeds)
@settings(max_examples=25, deadline=None)
def test_routes_in_evaluation_files_are_read_as_they_were(seed: int) -> None:
    for route in random_routes(seed):
        keys = json.loads(ADAPTER.dump_json(route))
        assert ADAPTER.validate_python(keys) == route
        assert ("capped" in keys) == route.capped
        assert [len(entry.get("branches", [])) for entry in keys["corners"]] == [len(c.branches) for c in route.corners]


@given(seeds)
@settings(max_examples=15, deadline=None)
def test_run_json_of_schema_3_is_read_as_it_was(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    folder = tmp_path_factory.mktemp("route")
    for route in random_routes(seed):
        record = route_record(route, "some")
        assert (record["schema"] == 3) == (route.has_fittings or route.slope != 0)
        (folder / "run.json").write_text(json.dumps(record))
        assert read_route_folder(folder) == route


@given(st.floats(40, 300), st.floats(30, 150), st.sampled_from(["straight", "into", "out"]))
@settings(max_examples=30, deadline=None)
def test_tees_in_evaluation_files_are_read_as_they_were(diameter: float, angle: float, way: str) -> None:
    pipe = tee(diameter, angle, TeePassage(way), 2000)
    assert ADAPTER.validate_python(json.loads(ADAPTER.dump_json(pipe))) == pipe
    route = PipeRoute.from_corner(pipe)
    assert ADAPTER.validate_python(json.loads(ADAPTER.dump_json(route))) == route


@pytest.mark.parametrize("wrong", [3, "tee", [3], [{"angle_rad": 1.0}], [{"angle_rad": "wide"}], {"angle_rad": 1}])
def test_branches_that_are_none_are_refused(wrong: object) -> None:
    with pytest.raises(ValidationError):
        ADAPTER.validate_python(keys_of_pipe(tee(100, 90)) | {"branches": wrong})
