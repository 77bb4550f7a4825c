"""The seams that a simulator or an arm implements, how plugins are found, and what they may use.

A plugin imports from `pipenav.backends`, `pipenav.robots`, `pipenav.pipes` and `pipenav.errors` (and the array types and
unit conversions in `pipenav.arrays` and `pipenav.units`), and from nothing else of pipenav.
"""

from pipenav.backends import safety
from pipenav.backends.backend import CONTROL_PERIOD, Backend, BackendOptions, Simulator, Variation, Viewer
from pipenav.backends.contact_force import Windows, strongest
from pipenav.backends.messages import Command, Control, Reading, Truth
from pipenav.backends.real_robot import (
    ArmStart,
    Calibrator,
    Emulated,
    Finding,
    RealRobot,
    Recoder,
    Sent,
    load_real_robot,
)
from pipenav.backends.registry import (
    DEFAULT_SIMULATOR,
    SimulatorSettings,
    availability,
    check_options,
    find_backends,
    load_backend,
    load_simulator,
    open_backend,
    open_simulator,
    open_space,
)
from pipenav.backends.safety import Bounds, Deadlines, Limited, Repeats, Stopped
from pipenav.backends.spatial import HALVES, SpaceBackend, SpaceReading, SpaceTruth
from pipenav.backends.wall_boxes import OUTER_THICKNESS, PARKED, WALL_HALF_HEIGHT, Edge, WallBoxes, wall_boxes

__all__ = [
    "CONTROL_PERIOD",
    "DEFAULT_SIMULATOR",
    "HALVES",
    "OUTER_THICKNESS",
    "PARKED",
    "WALL_HALF_HEIGHT",
    "ArmStart",
    "Backend",
    "BackendOptions",
    "Bounds",
    "Calibrator",
    "Command",
    "Control",
    "Deadlines",
    "Edge",
    "Emulated",
    "Finding",
    "Limited",
    "Reading",
    "RealRobot",
    "Recoder",
    "Repeats",
    "Sent",
    "Simulator",
    "SimulatorSettings",
    "SpaceBackend",
    "SpaceReading",
    "SpaceTruth",
    "Stopped",
    "Truth",
    "Variation",
    "Viewer",
    "WallBoxes",
    "Windows",
    "availability",
    "check_options",
    "find_backends",
    "load_backend",
    "load_real_robot",
    "load_simulator",
    "open_backend",
    "open_simulator",
    "open_space",
    "safety",
    "strongest",
    "wall_boxes",
]
