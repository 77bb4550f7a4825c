"""Jobs, and the places where they run: this process, several, or a cluster."""

from pipenav.jobs.driver import JobsLost, run_jobs
from pipenav.jobs.job import (
    Done,
    Ending,
    Event,
    Failed,
    Job,
    JobControl,
    JobFunction,
    JobStopped,
    Kept,
    Lost,
    Progressed,
    Stopped,
    ending_of,
    portable,
)
from pipenav.jobs.place import HearProgress, Place, ShouldStop, Slots
from pipenav.jobs.places import chosen_place, load_place
from pipenav.jobs.store import JobStore, MemoryStore, Store
from pipenav.processes.cores import usable_cores

__all__ = [
    "Done",
    "Ending",
    "Event",
    "Failed",
    "HearProgress",
    "Job",
    "JobControl",
    "JobFunction",
    "JobStopped",
    "JobStore",
    "JobsLost",
    "Kept",
    "Lost",
    "MemoryStore",
    "Place",
    "Progressed",
    "ShouldStop",
    "Slots",
    "Stopped",
    "Store",
    "chosen_place",
    "ending_of",
    "load_place",
    "portable",
    "run_jobs",
    "usable_cores",
]
