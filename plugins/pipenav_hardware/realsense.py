"""An Intel RealSense depth camera as a range scanner: the middle row of its depth image. Needs pipenav[realsense]."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np

from pipenav.errors import PipenavError
from pipenav_hardware.arm_config import ScannerConfig
from pipenav_hardware.ranging import RangeScan, RangeSensor, SensorLost, mounted

WIDTH, HEIGHT, RATE = 848, 480, 30
ROWS = 5
"""Number of rows around the middle whose nearest valid depth counts: one row is noisier and misses thin edges."""

RANGE_MIN, RANGE_MAX = 0.1, 1.0
"""Range of the thesis's sensor (4.3) [m]: a D435 sees from 0.11 m on, and farther than a pipe's corner needs."""


class RealSenseScanner(RangeSensor):
    """A depth camera: its depth along the optical axis becomes range along each column's ray, by its own intrinsics."""

    def __init__(self, config: ScannerConfig) -> None:
        try:
            self._library: Any = importlib.import_module("pyrealsense2")
        except ImportError:
            raise PipenavError(
                "the RealSense driver needs Python module 'pyrealsense2': pip install 'pipenav[realsense]'."
            ) from None
        settings = self._library.config()
        settings.enable_stream(self._library.stream.depth, WIDTH, HEIGHT, self._library.format.z16, RATE)
        self._pipeline = self._library.pipeline()
        try:
            profile = self._pipeline.start(settings)
        except RuntimeError as error:
            raise SensorLost("RealSense camera", f"does not start ({error})") from error
        stream = profile.get_stream(self._library.stream.depth).as_video_stream_profile()
        lens = stream.get_intrinsics()
        self._scale = profile.get_device().first_depth_sensor().get_depth_scale()
        tangents = (np.arange(lens.width) - lens.ppx) / lens.fx  # right of the axis is positive
        self.angles = mounted(-np.arctan(tangents)[::-1], config)
        self._stretch = np.sqrt(1 + tangents**2)
        self.range_min, self.range_max, self.rejected = RANGE_MIN, RANGE_MAX, 0
        self._latest: RangeScan | None = None

    def fileno(self) -> int:
        return -1

    def pump(self, now: float) -> None:
        frames = self._pipeline.poll_for_frames()
        frame = frames.get_depth_frame() if frames else None
        if frame:
            distances = scanline(np.asanyarray(frame.get_data()), self._scale, self._stretch)
            self._latest = RangeScan(distances, now, int(frame.get_frame_number()))

    def latest(self) -> RangeScan | None:
        return self._latest

    def close(self) -> None:
        self._pipeline.stop()


def scanline(depth: Any, scale: float, stretch: Any) -> tuple[int, ...]:
    """Ranges [mm] from left-to-right depth columns, in the order right to left; 0 where no depth is known.

    Args:
        depth: raw depth image, (rows, columns); 0 is unknown.
        scale: metres per raw unit.
        stretch: range over depth for every column, (columns,).
    """
    middle = len(depth) // 2
    band = depth[middle - ROWS // 2 : middle + ROWS // 2 + 1].astype(float)
    band[band == 0] = math.inf
    nearest = band.min(axis=0) * scale * stretch * 1e3
    return tuple(0 if math.isinf(value) else round(value) for value in nearest[::-1])
