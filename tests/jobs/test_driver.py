"""Jobs end alike at every place, and no end of a process, a job or a driver loses what was finished."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from helpers.jobs import Heard, cores, deaf, doubled, faulty, killed, killed_at_first, numbers, one, patient, refused
from helpers.waiting import wait_until
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import OutOfRange
from pipenav.jobs import Done, Job, JobsLost, JobStore, Kept, Lost, Place, Progressed, Stopped, run_jobs
from pipenav.jobs.here import HerePlace
from pipenav.jobs.processes import ProcessesPlace

PLACES = {"here": lambda: HerePlace(), "processes": lambda: ProcessesPlace("2")}


@pytest.fixture(params=PLACES)
def place(request: pytest.FixtureRequest) -> Place:
    request.getfixturevalue("helpers_for_children")
    return PLACES[request.param]()


@pytest.fixture
def processes(request: pytest.FixtureRequest) -> Place:
    request.getfixturevalue("helpers_for_children")
    return ProcessesPlace("2")


def contents(heard: Heard) -> dict[str, bytes]:
    return {event.job.key: event.content for event in heard.of(Done)}


def test_every_job_is_done_once_and_its_result_is_heard(place: Place) -> None:
    heard = Heard()
    assert run_jobs(place, numbers(7), heard)
    assert contents(heard) == {f"number-{i}": str(2 * i).encode() for i in range(7)}
    assert len(heard.of(Done)) == 7
    assert all(event.progress == event.job.data for event in heard.of(Progressed))


def test_no_job_is_asked_for_before_there_is_a_slot_for_it(place: Place) -> None:
    heard, asked = Heard(), []

    def jobs():
        for job in numbers(6):
            assert len(asked) - len(heard.of(Done)) <= 2
            asked.append(job)
            yield job

    assert run_jobs(place, jobs(), heard)


def test_a_users_error_comes_as_it_was_and_is_not_tried_again(place: Place) -> None:
    heard = Heard()
    with pytest.raises(OutOfRange) as found:
        run_jobs(place, one(refused, 5), heard)
    assert str(found.value) == str(OutOfRange("angle", 5.0, 10, 20, "deg"))
    assert not heard.of(Lost)


def test_a_fault_comes_with_its_place(processes: Place) -> None:
    with pytest.raises(RuntimeError, match=r"in faulty(.|\n)*by nothing"):
        run_jobs(processes, one(faulty))


def test_a_job_that_cannot_be_read_fails(processes: Place) -> None:
    """The function's module is here but not where the job runs."""
    module = type(sys)("only_here")
    exec("def function(data, control):\n    return b''\n", module.__dict__)
    sys.modules["only_here"] = module
    try:
        with pytest.raises(RuntimeError, match="only_here"):
            run_jobs(processes, one(module.function))
    finally:
        del sys.modules["only_here"]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_a_job_that_ends_its_process_costs_only_itself(processes: Place, number: signal.Signals) -> None:
    heard = Heard()
    poison = Job("poison", "the poison", killed, int(number))
    with pytest.raises(JobsLost, match=f"a job was lost 3 times: the poison .*{number.name}"):
        run_jobs(processes, [poison, *numbers(5)], heard)
    assert len(heard.of(Lost)) == 3
    assert len(contents(heard)) == 5


def test_a_lost_job_is_tried_three_times_in_all(processes: Place, tmp_path: Path) -> None:
    heard = Heard()
    assert run_jobs(processes, one(killed_at_first, str(tmp_path)), heard)
    assert contents(heard) == {"one": b"at last"}
    assert len(heard.of(Lost)) == 2


def stopped_after_begin(file: Path) -> bool:
    return file.with_suffix(".runs").exists()


def test_jobs_that_ask_save_before_they_stop(place: Place, tmp_path: Path) -> None:
    file, heard = tmp_path / "saved", Heard()
    assert not run_jobs(place, one(patient, str(file)), heard, lambda: stopped_after_begin(file))
    assert file.exists()
    assert not heard.of(Lost)


def test_a_job_that_never_asks_is_ended(processes: Place, tmp_path: Path) -> None:
    file = tmp_path / "deaf"
    assert not run_jobs(processes, one(deaf, str(file)), should_stop=lambda: stopped_after_begin(file))


def test_one_job_can_be_stopped_while_the_others_go_on(place: Place, tmp_path: Path) -> None:
    file, heard = tmp_path / "saved", Heard()

    def hear(event: object) -> bool:
        heard(event)  # type: ignore[arg-type]
        return isinstance(event, Progressed) and event.progress == "waiting"

    assert run_jobs(place, [*one(patient, str(file)), *numbers(3)], hear)
    assert [event.job.key for event in heard.of(Stopped)] == ["one"]
    assert len(contents(heard)) == 3


def test_what_is_kept_is_not_done_again(place: Place, tmp_path: Path) -> None:
    store = JobStore(tmp_path / "store", {"what": "numbers"})
    assert run_jobs(place, numbers(3), store=store)
    heard = Heard()
    assert run_jobs(place, numbers(5), heard, store=store)
    assert [event.job.key for event in heard.of(Kept)] == ["number-0", "number-1", "number-2"]
    assert sorted(contents(heard)) == ["number-3", "number-4"]
    assert [store.read(f"number-{i}") for i in range(5)] == [str(2 * i).encode() for i in range(5)]


@pytest.mark.usefixtures("helpers_for_children")
def test_processes_share_the_cores() -> None:
    heard = Heard()
    many = [Job(str(i), str(i), cores, None, cores=64) for i in range(2)]
    assert run_jobs(ProcessesPlace("64"), many, heard)
    assert set(contents(heard).values()) == {b"1"}


DRIVER = """
import sys
from pathlib import Path
from helpers.jobs import numbers, deaf, one
from pipenav.jobs import JobStore, run_jobs
from pipenav.jobs.processes import ProcessesPlace
store = JobStore(Path(sys.argv[1]), {})
run_jobs(ProcessesPlace("2"), [*numbers(4), *one(deaf, sys.argv[2])], store=store)
"""


def test_a_driver_that_is_killed_loses_no_finished_job(processes: Place, tmp_path: Path) -> None:
    folder, file = tmp_path / "store", tmp_path / "deaf"
    with subprocess.Popen([sys.executable, "-c", DRIVER, str(folder), str(file)]) as driver:
        wait_until(lambda: len(list(folder.glob("number-*"))) == 4 and stopped_after_begin(file), "four are done")
        os.kill(driver.pid, signal.SIGKILL)
    heard = Heard()
    assert run_jobs(processes, numbers(5), heard, store=JobStore(folder, {}))
    assert len(heard.of(Kept)) == 4
    assert list(contents(heard)) == ["number-4"]


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(0, 9), unique=True))
def test_a_store_has_what_was_written_and_nothing_else(written: list[int]) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as path:
        store = JobStore(Path(path) / "store", {})
        for i in written:
            store.write(f"job-{i}", bytes([i, 10, i]))
        assert [i for i in range(10) if store.has(f"job-{i}")] == sorted(written)
        assert all(store.read(f"job-{i}") == bytes([i, 10, i]) for i in written)


def test_places_open_from_another_thread_too(place: Place) -> None:
    heard = Heard()
    thread = threading.Thread(target=lambda: run_jobs(place, one(doubled, 4), heard))
    thread.start()
    thread.join()
    assert contents(heard) == {"one": b"8"}
