"""The connection to a Ray cluster: one that runs, or one of our own on this machine."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import ray
from ray.job_config import JobConfig

from pipenav.errors import PipenavError, shown
from pipenav.jobs import usable_cores

AUTO = "auto"
"""The address of the cluster that runs on this machine, or else of a new one on it."""

PROBE_S = 2.0
"""Longest wait for an answer of a cluster's address [s]; Ray itself would try again for minutes."""

QUICK_HEALTH = {
    "health_check_initial_delay_ms": 1000,
    "health_check_period_ms": 1000,
    "health_check_timeout_ms": 1000,
    "health_check_failure_threshold": 3,
}
"""Health checks by which a new cluster notices a node's death in 3 s; by default work stands still for 13 s."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment of workers: a job has the cores that were set aside for it, and starts its own threads."""

STORE_BYTES = 200_000_000
"""Memory for results on their way in a new cluster [bytes]; Ray would take a third of the machine."""


class Address(NamedTuple):
    """Host and port of a cluster."""

    host: str
    port: int

    @classmethod
    def parsed(cls, text: str) -> Address | None:
        """The address from a text; None for `auto`.

        Raises:
            PipenavError: it is neither.
        """
        if text == AUTO:
            return None
        host, colon, port = text.rpartition(":")
        if not (colon and host and "/" not in host and port.isascii() and port.isdigit() and 0 < int(port) < 65536):
            raise PipenavError(
                f"{shown(text)} is no address of a Ray cluster: write it as HOST:PORT, as `ray start --head` says it, "
                f"or as {AUTO}."
            )
        return cls(host.strip("[]"), int(port))

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"

    def check(self) -> None:
        """Check that a Ray cluster answers there.

        Raises:
            PipenavError: nobody does, or somebody else.
        """
        start = "look at the address that `ray start --head` gave, and at the firewall"
        try:
            socket.create_connection((self.host, self.port), PROBE_S).close()
        except OSError as error:
            raise PipenavError(f"no Ray cluster answers at {self}, {error.strerror or error}: {start}.") from error
        if not _answers_as_ray(str(self)):
            raise PipenavError(f"what answers at {self} is no Ray cluster: {start}.")


def _answers_as_ray(address: str) -> bool:
    """Whether a Ray cluster answers, asked in a thread, since Ray's own client waits for minutes."""
    heard = threading.Event()

    def ask() -> None:
        with contextlib.suppress(Exception):  # Ray has many errors for this, none of them public
            if ray._raylet.GcsClient(address=address).internal_kv_keys(b"session", None) is not None:
                heard.set()

    threading.Thread(target=ask, daemon=True).start()
    return heard.wait(PROBE_S)


class _NoFolders(list[str]):
    """Folders of this process that workers of Ray put on their import path: none, whatever Ray adds."""

    def extend(self, _folders: Iterable[str]) -> None:
        """Leave out Ray's addition, the current folder: a `numpy.py` that lies there is not to be run."""


@contextlib.contextmanager
def connected(address: Address | None) -> Iterator[None]:
    """A connection of this process to a cluster, until the block is left.

    Raises:
        PipenavError: there is none, or this machine does not belong to it.
    """
    with contextlib.ExitStack() as stack:
        if address is not None:
            address.check()
            _join(str(address))
        elif os.environ.get("RAY_ADDRESS") or _runs_here():
            _join(AUTO)
        else:
            folder = tempfile.mkdtemp(prefix=f"pipenav-ray-{os.getpid()}-")
            stack.callback(shutil.rmtree, folder, ignore_errors=True)
            _begin(folder)
        stack.callback(ray.shutdown)
        yield


def _join(address: str) -> None:
    """Connect to a cluster that runs."""
    try:
        _initialise(address=address)
    except PipenavError:
        raise
    except Exception as error:  # Ray has many errors for this
        what = " ".join(str(error).split())
        raise PipenavError(
            f"this process cannot join the Ray cluster at {address}, {what[:300]}: the command must run on a machine "
            "that belongs to it (`ray start --address ...`), with the same versions of Ray and Python."
        ) from error


def _begin(folder: str) -> None:
    """Start a cluster of this machine's cores, which ends with this process."""
    _initialise(
        num_cpus=usable_cores(),
        include_dashboard=False,
        object_store_memory=STORE_BYTES,
        _temp_dir=folder,
        _system_config=QUICK_HEALTH,
    )


def _initialise(**settings: Any) -> None:
    """Connect to Ray, which changes nothing in what this process does on signals, and prints nothing."""
    kept = _handlers()
    try:
        variables = ONE_THREAD | {"PYTHONSAFEPATH": "1"}
        job = JobConfig()
        job._py_driver_sys_path = _NoFolders()
        settings |= {"job_config": job, "runtime_env": {"env_vars": variables}}
        ray.init(log_to_driver=False, logging_level="ERROR", **settings)
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


def _handlers() -> Mapping[int, Any]:
    """Handlers of the signals that Ray replaces; none where they are not ours to change."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    return {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}


def _runs_here() -> bool:
    """Whether a Ray cluster that somebody started runs on this machine."""
    with contextlib.suppress(Exception):  # a function of Ray's own, whose place may change
        from ray._private.services import find_gcs_addresses

        return bool(find_gcs_addresses())
    return False
