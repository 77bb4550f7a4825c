"""The laser fan: where beams point, how far they reach, what the sensor makes of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipenav.pipes.corner import PipeCorner
from pipenav.robots.laser import cast, measure
from pipenav.robots.parts import Laser
from pipenav.robots.robot import load_robot

BASIC = load_robot("basic").laser
fans = st.builds(
    lambda beams, fan, kind: BASIC.model_copy(update={"beams": beams, "fan_deg": fan, "fan": kind}),
    st.integers(2, 400),
    st.floats(1, 360),
    st.sampled_from(["centred", "printed"]),
)
pipes = st.builds(PipeCorner.of, st.floats(70, 120), st.floats(55, 125), st.sampled_from(["left", "right"]))


@settings(max_examples=40)
@given(fans)
def test_printed_fan_is_eq_3_16(laser: Laser) -> None:
    # beta_i = (180 - Phi) / 2 + Phi / N (i - 1) deg, from the laser's right-hand axis; straight ahead is 90 deg.
    i = np.arange(1, laser.beams + 1)
    beta = (180 - laser.fan_deg) / 2 + laser.fan_deg / laser.beams * (i - 1)
    printed = laser.model_copy(update={"fan": "printed"})
    assert np.degrees(printed.angles) + 90 == pytest.approx(beta)


@settings(max_examples=40)
@given(fans)
def test_centred_fan_is_the_printed_one_turned_by_half_a_sector_and_symmetric(laser: Laser) -> None:
    centred, printed = (laser.model_copy(update={"fan": kind}).angles for kind in ("centred", "printed"))
    assert centred == pytest.approx(-centred[::-1], abs=1e-12)
    assert np.degrees(centred - printed) == pytest.approx(laser.fan_deg / laser.beams / 2)


def test_the_basic_robots_beams_are_18_deg_apart() -> None:
    assert np.degrees(BASIC.angles) == pytest.approx([-81, -63, -45, -27, -9, 9, 27, 45, 63, 81])


distances = arrays(float, (3, 4), elements=st.one_of(st.floats(0, 20), st.just(np.inf)))


@settings(max_examples=40)
@given(distances)
def test_readings_are_multiples_of_the_resolution_within_the_range(true) -> None:  # type: ignore[no-untyped-def]
    read = measure(BASIC, true)
    steps = read / BASIC.resolution
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert np.all((read >= BASIC.range_min) & (read <= BASIC.range_max))
    within = (true >= BASIC.range_min) & (true <= BASIC.range_max)
    assert np.all(np.abs(read - true)[within] <= BASIC.resolution / 2 + 1e-12)


@settings(max_examples=40)
@given(pipes, st.integers(0, 2**32 - 1))
def test_beams_end_on_the_wall_that_they_meet_first(pipe: PipeCorner, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.3, 0.3, (200, 2))
    points = points[pipe.contains(points)][:5]
    headings = rng.uniform(-np.pi, np.pi, (len(points), 10))
    segments = np.broadcast_to(pipe.segments, (len(points), *pipe.segments.shape))
    reach = cast(points, headings, segments)[..., None]
    direction = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    met = np.isfinite(reach[..., 0])
    assert met.sum() >= 0.8 * met.size  # the rest leaves by an open end
    short, beyond = (points[:, None] + (reach * (1 + s)) * direction for s in (-1e-9, 1e-6))
    assert pipe.contains(short[met]).all()
    assert not pipe.contains(beyond[met]).any()
    for share in (0.25, 0.5, 0.75):  # the way to the wall is free
        assert pipe.contains((points[:, None] + share * reach * direction)[met]).all()


def test_a_beam_across_the_pipe_reads_the_radius() -> None:
    pipe = PipeCorner.of(100, 90)
    reach = cast(np.array([[-0.3, 0.0]]), np.array([[np.pi / 2, -np.pi / 2, 0.0, np.pi]]), pipe.segments[None])
    assert reach[0] == pytest.approx([0.05, 0.05, 0.35, np.inf])
