"""The seams that a simulator or an arm implements, how plugins are found, and what they may use.

A plugin imports `pipenav.backends`, `robots`, `pipes`, `errors`, `arrays` and `units`, and nothing else of pipenav.
`read_toml` reads TOML files safely.
"""

from pipenav.backends import safety
from pipenav.backends.backend import (
    CONTROL_PERIOD,
    Backend,
    BackendOptions,
    Simulator,
    Variation,
    physics_steps,
)
from pipenav.backends.contact_force import Windows, strongest
from pipenav.backends.messages import Command, Control, Reading, Truth
from pipenav.backends.plugins import find_backends
from pipenav.backends.real_robot import (
    ArmStart,
    Calibrator,
    Emulated,
    Finding,
    RealRobot,
    Recoder,
    Sent,
    ServoHealth,
    load_real_robot,
)
from pipenav.backends.refusals import (
    CannotIncline,
    CannotPull,
    CannotVary,
    NoViewer,
    PlaneOnly,
    TooManyWalls,
    UnevenTimestep,
)
from pipenav.backends.registry import check_options, load_backend, open_backend
from pipenav.backends.requirements import availability
from pipenav.backends.safety import Bounds, Deadlines, Limited, Repeats, Stopped, TorqueUnconfirmed
from pipenav.backends.simulators import DEFAULT_SIMULATOR, SimulatorSettings, load_simulator, open_simulator, open_space
from pipenav.backends.spatial import HALVES, SpaceBackend, SpaceReading, SpaceTruth
from pipenav.backends.viewer import HasWindow, Sight, Viewer
from pipenav.backends.wall_boxes import OUTER_THICKNESS, PARKED, WALL_HALF_HEIGHT, Edge, WallBoxes, wall_boxes
from pipenav.processes.children import Worker, WorkerEnded, start_python, start_worker, worker_end
from pipenav.storage.temporary import temporary_folder
from pipenav.storage.text_files import read_toml

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
    "CannotIncline",
    "CannotPull",
    "CannotVary",
    "Command",
    "Control",
    "Deadlines",
    "Edge",
    "Emulated",
    "Finding",
    "HasWindow",
    "Limited",
    "NoViewer",
    "PlaneOnly",
    "Reading",
    "RealRobot",
    "Recoder",
    "Repeats",
    "Sent",
    "ServoHealth",
    "Sight",
    "Simulator",
    "SimulatorSettings",
    "SpaceBackend",
    "SpaceReading",
    "SpaceTruth",
    "Stopped",
    "TooManyWalls",
    "TorqueUnconfirmed",
    "Truth",
    "UnevenTimestep",
    "Variation",
    "Viewer",
    "WallBoxes",
    "Windows",
    "Worker",
    "WorkerEnded",
    "availability",
    "check_options",
    "find_backends",
    "load_backend",
    "load_real_robot",
    "load_simulator",
    "open_backend",
    "open_simulator",
    "open_space",
    "physics_steps",
    "read_toml",
    "safety",
    "start_python",
    "start_worker",
    "strongest",
    "temporary_folder",
    "wall_boxes",
    "worker_end",
]
