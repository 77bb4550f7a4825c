"""A port that cannot be opened is explained, with what to do."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from pipenav_hardware.port_problems import holder_of, port_problem


def test_a_port_that_is_not_there(tmp_path: Path) -> None:
    message = str(port_problem(str(tmp_path / "ttyUSB0"), FileNotFoundError()))
    assert message.startswith(f"there is no port {tmp_path}/ttyUSB0: plug the adapter in")


def test_a_port_of_another_group_names_the_group(tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB0"
    port.touch()
    message = str(port_problem(str(port), PermissionError(errno.EACCES, "denied")))
    assert f"belongs to group {port.group()}" in message
    assert f"usermod -a -G {port.group()}" in message


def test_a_busy_port_names_who_holds_it(tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB0"
    with port.open("w"):
        message = str(port_problem(str(port), OSError(errno.EBUSY, "busy")))
    assert "is in use by" in message and "end that process" in message


def test_the_holder_of_a_terminal_is_found_by_its_open_file(monkeypatch: pytest.MonkeyPatch) -> None:
    master, slave = os.openpty()
    pid = os.getpid()
    monkeypatch.setattr(os, "getpid", lambda: 0)  # it never names itself
    assert f"process {pid} (" in holder_of(os.ttyname(slave))
    os.close(master)
    os.close(slave)


def test_a_file_that_is_no_port(tmp_path: Path) -> None:
    port = tmp_path / "notes.txt"
    port.touch()
    assert "cannot be opened as a serial port" in str(port_problem(str(port), OSError(errno.ENOTTY, "no tty")))
