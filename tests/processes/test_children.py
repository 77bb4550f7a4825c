"""Children end with their parent, and leave nothing behind."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from helpers.processes import Family, started
from helpers.waiting import wait_until

from pipenav.errors import OutOfRange, PipenavError, UnknownName
from pipenav.processes.children import WorkerEnded, start_worker
from pipenav.storage.temporary import temporary_folder

ENDS_WITHIN = 5.0
"""Time in which nothing of a killed command may be left [s]."""

LONG = {
    "experiment": ("experiment", "f", "--seeds", "2", "--jobs", "2", "--out", "tried"),
    "eval": ("eval", "--policy", "arm", "--episodes", "300", "--backend", "pybullet", "--out", "measured"),
    "run-real": ("run-real", "--emulate", "--allow-slow-bus", "--patience", "8", "--out", "real"),
    "view": ("view", "--policy", "arm", "--out", "film.mp4"),
}
CHILD = {
    "experiment": "pipenav.jobs.worker",
    "eval": "pipenav_pybullet.worker",
    "run-real": "supervisor.py",
    "view": "ffmpeg",
}


@pytest.mark.slow
@pytest.mark.parametrize("command", LONG)
def test_nothing_is_left_of_a_command_that_was_killed(command: str, tmp_path: Path) -> None:
    if command == "eval":
        pytest.importorskip("pybullet")
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    with started(*LONG[command], folder=tmp_path, TMPDIR=str(temporary)) as family:
        wait_until(lambda: any(CHILD[command] in line for line in family.alive().values()), f"{command} has children")
        time.sleep(1.0)
        os.kill(family.command.pid, signal.SIGKILL)
        family.command.wait()
        require_end(family)
    program = "from pipenav.storage.temporary import temporary_folder\nwith temporary_folder('later'):\n    pass\n"
    later = [sys.executable, "-c", program]
    subprocess.run(later, env=os.environ | {"TMPDIR": str(temporary)}, check=True)
    assert not list(temporary.glob("pipenav-*"))


def require_end(family: Family) -> None:
    until = time.monotonic() + ENDS_WITHIN
    while (left := family.alive()) and time.monotonic() < until:
        time.sleep(0.1)
    assert not left


def test_folders_of_processes_that_live_stay(tmp_path: Path) -> None:
    program = (
        "import sys\nfrom pipenav.storage.temporary import temporary_folder\n"
        "with temporary_folder('later') as folder:\n    print(folder, flush=True)\n    sys.stdin.read()\n"
    )
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", program], env=environment, text=True, **pipes) as first:  # type: ignore[call-overload]
        folder = Path(first.stdout.readline().strip())
        subprocess.run([sys.executable, "-c", program], env=environment, stdin=subprocess.DEVNULL, check=True)
        assert folder.is_dir()
        first.stdin.close()
    assert not list(tmp_path.iterdir())


def test_a_folder_goes_at_the_end_of_its_context() -> None:
    with temporary_folder("test") as folder:
        (folder / "file").touch()
        assert f"-{os.getpid()}-" in folder.name
    assert not folder.exists()


@pytest.mark.usefixtures("helpers_for_children")
def test_a_worker_outlives_the_thread_that_started_it() -> None:
    workers = []
    thread = threading.Thread(target=lambda: workers.append(start_worker("helpers.answering")))
    thread.start()
    thread.join()
    (worker,) = workers
    worker.send("first")
    assert worker.receive() == "first"
    time.sleep(0.2)
    worker.send("second")
    assert worker.receive() == "second"
    worker.close()
    assert worker.process.returncode == 0


@pytest.mark.usefixtures("helpers_for_children")
def test_a_worker_that_has_ended_is_told_from_one_that_works() -> None:
    worker = start_worker("helpers.answering")
    worker.process.kill()
    worker.process.wait()
    with pytest.raises(WorkerEnded):
        worker.send("hello")
        worker.receive()
    worker.close()


@pytest.mark.parametrize(
    "error", [UnknownName("robot", "basik", ["basic"]), OutOfRange("angle", 5, 10, 20, "deg"), PipenavError("plain")]
)
def test_errors_come_through_a_pipe_as_they_were(error: PipenavError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
