"""Beams of the robot's laser from a real scanner, a front sensor or a depth camera."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.arm import ANGLES, ROBOT, scan
from hypothesis import given
from hypothesis import strategies as st
from pipenav_hardware.beam_filter import DISBELIEF, BeamFilter
from pipenav_hardware.ranging import AFTER_SCAN, RangeScan, late_for_scan
from pipenav_hardware.realsense import scanline

from pipenav.errors import PipenavError


def beam_filter() -> BeamFilter:
    return BeamFilter(ROBOT.laser, ANGLES, 0.02, 1.0)


def test_a_beam_is_the_median_of_its_neighbourhood() -> None:
    rng = np.random.default_rng(0)
    errors = []
    for i in range(50):
        noisy = np.round(200 + rng.normal(0, 10, len(ANGLES))).astype(int)
        noisy[rng.random(len(ANGLES)) < 0.2] = 20
        errors.append(np.abs(beam_filter().beams(RangeScan(tuple(noisy), 0.0, i), None) - 0.2).max())
    assert np.mean(errors) < 0.01


def test_a_minimum_from_nowhere_is_doubted_for_a_while() -> None:
    made = beam_filter()
    made.beams(scan(300), None)
    for _ in range(DISBELIEF):
        assert (made.beams(scan(20), None) == 0.3).all()
    assert (made.beams(scan(20), None) == 0.02).all()


def test_a_wall_that_comes_nearer_is_believed() -> None:
    made = beam_filter()
    for millimetres in (300, 210, 120, 60, 20):
        assert (made.beams(scan(millimetres), None) == millimetres / 1e3).all()


def test_error_codes_are_no_distances() -> None:
    made = beam_filter()
    assert (made.beams(scan(19), None) == ROBOT.laser.range_max).all()
    assert made.all_invalid


def test_the_front_sensor_sees_nearer_than_the_scanner() -> None:
    close = beam_filter().beams(scan(0), 0.012)
    middle = np.abs(ROBOT.laser.angles) < 0.2
    assert (close[middle] == 0.01).all()
    assert (close[~middle] == ROBOT.laser.range_max).all()
    assert (beam_filter().beams(scan(300), 0.28) == 0.3).all(), "within the scanner's range the scanner counts"


def test_a_scanner_that_sees_too_little_is_refused() -> None:
    with pytest.raises(PipenavError, match="does not see the beam at -81 deg"):
        BeamFilter(ROBOT.laser, np.deg2rad(np.arange(-43.0, 43.0)), 0.1, 1.0)


def test_a_depth_image_becomes_ranges_from_right_to_left() -> None:
    depth = np.full((9, 4), 1000, np.uint16)
    depth[:, 0] = 0
    depth[4, 3] = 500
    assert scanline(depth, 0.001, np.array([2.0, 1.0, 1.0, 2.0])) == (1000, 1000, 1000, 0)


@given(st.floats(0, 0.1), st.floats(-2e-4, 2e-4))
def test_ticks_come_to_begin_just_after_a_scan_and_stay_there(phase: float, drift: float) -> None:
    """It holds wherever they begin, and although the scanner's clock is a little faster or slower."""
    due, stamp = 100.0, 100.0 - phase
    for _ in range(80):
        due += 0.1 - late_for_scan(due, RangeScan((300,), stamp, 1))
        while stamp + 0.1 + drift <= due:
            stamp += 0.1 + drift
    assert abs(math.remainder(due - stamp - AFTER_SCAN, 0.1)) < 0.001
    assert late_for_scan(due, None) == 0.0
