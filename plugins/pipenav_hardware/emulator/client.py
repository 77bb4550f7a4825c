"""The host's side of the emulator: starting it and giving it orders."""

from __future__ import annotations

import contextlib
import json
import subprocess
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from pipenav.backends import ArmStart, start_python, temporary_folder
from pipenav.errors import PipenavError
from pipenav.pipes import PipeCorner
from pipenav.robots import RobotSpec
from pipenav_hardware.arm_config import ArmConfig, FrontSensorConfig, ScannerConfig, arm_toml, default_arm
from pipenav_hardware.emulator.config import EmulatorConfig, EmulatorSettings

HEALTHY = EmulatorSettings()
"""An arm that is mounted ideally, and with which nothing goes wrong."""


class Emulator:
    """An emulator process, until the end of its `with` block.

    Attributes:
        arm: description of the emulated arm, also as a file at `arm_path`.
        log_path: file of every byte on its lines, with its time.
    """

    def __init__(
        self,
        robot: RobotSpec,
        settings: EmulatorSettings = HEALTHY,
        pipe: PipeCorner | None = None,
        start: ArmStart | None = None,
        folder: Path | None = None,
    ) -> None:
        """
        Args:
            robot: the robot.
            settings: how the arm is built, and what goes wrong with it.
            pipe: the pipe around it; without one it stands free, its shafts in the middle of their turn.
            start: where it stands in the pipe; straight, at the pipe's beginning, where nothing is given.
            folder: folder for its log; a temporary one where nothing is given.
        """
        self._temporary = contextlib.ExitStack()
        self.folder = self._temporary.enter_context(temporary_folder("emulator"))
        self.log_path = (folder or self.folder) / "bus.jsonl"
        self.arm_path = self.folder / "arm.toml"
        self.arm = self._arm(robot, settings)
        self.arm_path.write_text(arm_toml(self.arm), encoding="utf-8")
        config = EmulatorConfig(
            robot=robot.name,
            arm=self.arm,
            settings=settings,
            pipe=pipe,
            q=None if start is None else tuple(float(value) for value in start.q),
            base=0.0 if start is None else start.base,
            log=self.log_path,
        )
        file = self.folder / "emulator.json"
        file.write_text(config.model_dump_json(), encoding="utf-8")
        pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
        # It outlives us by a moment, as an arm would: its supervisor must still reach the servos.
        self._process = start_python(
            "pipenav_hardware.emulator.server", [str(file)], True, text=True, start_new_session=True, **pipes
        )
        try:
            self._await_answer()
        except BaseException:
            self.close()
            raise

    def order(self, **order: Any) -> None:
        """Have something happen now: a fault by `fault=...`, `clear=True`, `place=[...]`, `plug="bus"`."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        self._await_answer()

    def close(self) -> None:
        """End the process; its log is complete then."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait(timeout=10)
        for stream in (self._process.stdout, self._process.stderr):
            if stream is not None:
                stream.close()
        self._temporary.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _arm(self, robot: RobotSpec, settings: EmulatorSettings) -> ArmConfig:
        """The arm's description, with ports in our folder."""
        scanner = ScannerConfig(driver="scip2", port=str(self.folder / "scanner"))
        front = FrontSensorConfig(port=str(self.folder / "front")) if settings.front_sensor else None
        ideal = default_arm(robot, str(self.folder / "servos"), scanner, front)
        if settings.mounted is None:
            return ideal
        return settings.mounted.model_copy(update={"port": ideal.port, "scanner": scanner, "front_sensor": front})

    def _await_answer(self) -> None:
        """Wait for the line that the process prints when it is ready, or has obeyed an order.

        Raises:
            PipenavError: it ended instead.
        """
        assert self._process.stdout is not None and self._process.stderr is not None
        if not self._process.stdout.readline():
            why = self._process.stderr.read().strip().splitlines()
            raise PipenavError(f"the emulator ended: {why[-1] if why else 'it said nothing'}.")
