"""Child processes of pipenav: they import nothing from the current folder, and end with their parent."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from multiprocessing import Pipe as pipe_ends
from multiprocessing.connection import Connection
from typing import Any

from pipenav.processes.safe_path import safe_environment

PARENTS_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that reach every process of a terminal or a service; the parent alone decides what they mean, and may save
first."""


class WorkerEnded(Exception):
    """A worker that was asked something has ended."""


def start_python(
    module: str, arguments: Sequence[str], outlives_parent: bool = False, **settings: Any
) -> subprocess.Popen[Any]:
    """Start `main(arguments)` of a module as a process of its own.

    Args:
        module: name of the module.
        arguments: arguments of its function `main`.
        outlives_parent: leave it to the child when to end after its parent; it must then notice by itself, as by an
            input that closes.
        settings: further settings of `subprocess.Popen`.
    """
    # The kernel takes the end of the thread that started a child for the parent's: only the main thread's is that.
    bound = not outlives_parent and threading.current_thread() is threading.main_thread()
    parent = str(os.getpid() if bound else 0)
    command = [sys.executable, "-P", "-m", "pipenav.processes.child", parent, module, *arguments]
    before = signal.pthread_sigmask(signal.SIG_BLOCK, PARENTS_SIGNALS)  # until the child ignores them
    try:
        return subprocess.Popen(command, env=safe_environment(), **settings)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Worker:
    """A child process with a pipe to it, whose end is the end of the child too.

    Attributes:
        end: our end of the pipe.
        process: the process.
    """

    def __init__(self, process: subprocess.Popen[Any], end: Connection[Any, Any]) -> None:
        self.process, self.end = process, end

    def send(self, message: Any) -> None:
        """Send a message.

        Raises:
            WorkerEnded: the process has ended.
        """
        try:
            self.end.send(message)
        except ConnectionError as error:
            raise WorkerEnded from error

    def receive(self) -> Any:
        """The next message of the process; waits for it.

        Raises:
            WorkerEnded: the process has ended.
        """
        try:
            return self.end.recv()
        except (EOFError, ConnectionError) as error:
            raise WorkerEnded from error

    def close(self, patience: float | None = None) -> None:
        """Close the pipe, at which the process ends, and wait for it; kill it where that takes longer than allowed.

        Args:
            patience: longest time to wait [s]; None for any time.
        """
        self.end.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(patience)
            return
        self.process.kill()
        self.process.wait()


def start_worker(module: str, **settings: Any) -> Worker:
    """Start a process that talks to us; `main` of its module gets the descriptor of its end of the pipe.

    Args:
        module: name of the module; its `main` calls `worker_end` with its arguments.
        settings: further settings of `subprocess.Popen`.
    """
    ours, theirs = pipe_ends()
    with theirs:
        process = start_python(module, [str(theirs.fileno())], pass_fds=[theirs.fileno()], **settings)
    return Worker(process, ours)


def worker_end(arguments: Sequence[str]) -> Connection[Any, Any]:
    """A worker's own end of the pipe to its parent, from the arguments of its `main`."""
    return Connection(int(arguments[0]))
