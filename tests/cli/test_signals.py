"""Signals are answered at once, and every command ends soon after, by the exit code of the signal."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from helpers.command import run
from helpers.processes import started
from helpers.waiting import wait_until

from pipenav.cli.signals import Interrupted, interrupts, stop_signals

ANSWERS_WITHIN, ENDS_WITHIN = 5.0, 15.0
"""Times for the first word and the end, from the signal on [s]; 1 and 5 are promised where the machine is not busy."""

LONG = {
    "train": ("train", "--preset", "pirate", "--set=check.every=10", "--out", "trained"),
    "eval": ("eval", "--policy", "arm", "--episodes", "500", "--out", "measured"),
    "eval in several processes": ("eval", "--policy", "arm", "--episodes", "300", "--backend", "pybullet"),
    "experiment": ("experiment", "f", "--seeds", "3", "--jobs", "2", "--out", "tried"),
    "tune": ("tune", "--jobs", "2", "--out", "searched"),
    "view": (
        "view",
        "--policy",
        "pirate",
        *(f"--pipes=d={d},angle=90" for d in (80, 90, 100, 110)),
        "--out",
        "film.mp4",
    ),
    "locate-target": ("locate-target", "--pipes", "working-range", "--robot", "high-fidelity"),
    "compare-backends": ("compare-backends", "--other", "mujoco"),
}


@pytest.mark.slow
@pytest.mark.realtime
@pytest.mark.flaky(
    reruns=2
)  # as MuJoCo loads, GLFW asks its version in a Python of its own, which an interrupt then hits
@pytest.mark.parametrize("seconds", [1.0, 3.0, 8.0])
@pytest.mark.parametrize("arguments", LONG.values(), ids=LONG)
def test_an_interrupt_is_answered_at_once_and_obeyed_soon(
    arguments: tuple[str, ...], seconds: float, tmp_path: Path
) -> None:
    if "pybullet" in arguments:
        pytest.importorskip("pybullet")
    with started(*arguments, folder=tmp_path) as family:
        time.sleep(seconds)
        if family.command.poll() is not None:
            pytest.skip("it was done before")
        sent = time.monotonic()
        os.killpg(family.command.pid, signal.SIGINT)  # as a terminal does
        assert family.command.stdout is not None
        for line in family.command.stdout:
            if line.startswith("stopping"):
                break
        answered = time.monotonic() - sent
        rest, _ = family.command.communicate(timeout=60)
        ended = time.monotonic() - sent
        assert family.command.returncode == 130, rest
        assert "Traceback" not in rest
        assert answered < ANSWERS_WITHIN
        assert ended < ENDS_WITHIN
        wait_until(lambda: not family.alive(), "its children have ended")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_exit_code_is_the_signals(
    number: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        try:
            os.kill(os.getpid(), number)
        except Exception as error:
            raise AssertionError("a signal is no error") from error

    monkeypatch.setattr("pipenav.cli.robots.robots", interrupted)
    monkeypatch.setattr("pipenav.cli.signals._leave_terminal", lambda: None)
    assert run("robots") == 128 + number
    assert capfd.readouterr().err == ("" if number == signal.SIGHUP else "stopping ...\n")


def test_libraries_that_turn_an_interrupt_into_an_error_do_not_hide_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted() -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except BaseException:
            raise ImportError("initialization failed") from None

    monkeypatch.setattr("pipenav.cli.robots.robots", interrupted)
    assert run("robots") == 130


def test_work_that_has_begun_to_ask_is_not_interrupted_but_asked_to_stop(capfd: pytest.CaptureFixture[str]) -> None:
    with interrupts(), stop_signals() as stopped:
        assert not stopped()
        os.kill(os.getpid(), signal.SIGTERM)
        assert stopped()
        assert stopped.exit_code == 143
        assert capfd.readouterr().err == "stopping, saving ...\n"
        with pytest.raises(Interrupted):
            os.kill(os.getpid(), signal.SIGINT)  # the second does not wait


def test_work_that_has_nothing_to_save_yet_is_interrupted() -> None:
    with interrupts(), stop_signals(), pytest.raises(Interrupted):
        os.kill(os.getpid(), signal.SIGINT)


def test_a_hang_up_that_is_ignored_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interrupts():
            os.kill(os.getpid(), signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_the_handlers_are_the_earlier_ones_again() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    with interrupts(), stop_signals():
        pass
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before
