"""Starting the emulator and giving it orders."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from pipenav.errors import PipenavError
from pipenav.pipes import PipeCorner
from pipenav.robots import RobotSpec
from pipenav_hardware.arm_config import ArmConfig, FrontSensorConfig, ScannerConfig, arm_toml, default_arm


class Emulator:
    """An emulator process, until the end of its `with` block.

    Attributes:
        arm: the description of the emulated arm, also as `arm_path`.
        log_path: the timed byte log.
    """

    def __init__(
        self,
        robot: RobotSpec,
        pipe: PipeCorner | None = None,
        *,
        folder: Path | None = None,
        q: Sequence[float] | None = None,
        base: float = 0.0,
        mounted: ArmConfig | None = None,
        faults: Sequence[dict[str, Any]] = (),
        front: bool = True,
        **settings: Any,
    ) -> None:
        self._temporary = tempfile.TemporaryDirectory(prefix="pipenav-emulator-")
        self.folder = Path(self._temporary.name)
        self.log_path = (folder or self.folder) / "bus.jsonl"
        self.arm_path = self.folder / "arm.toml"
        scanner = ScannerConfig(driver="scip2", port=str(self.folder / "scanner"))
        front_sensor = FrontSensorConfig(port=str(self.folder / "front")) if front else None
        self.arm = default_arm(robot, str(self.folder / "servos"), scanner, front_sensor)
        if mounted is not None:
            ports = {"port": self.arm.port, "scanner": scanner, "front_sensor": front_sensor}
            self.arm = mounted.model_copy(update=ports)
        self.arm_path.write_text(arm_toml(self.arm), encoding="utf-8")
        config = {
            "robot": robot.name, "arm": self.arm.model_dump(), "pipe": pipe and pipe.model_dump(), "base": base,
            "q": None if q is None else [float(value) for value in q], "faults": list(faults),
            "log": str(self.log_path), **settings,
        }  # fmt: skip
        file = self.folder / "emulator.json"
        file.write_text(json.dumps(config), encoding="utf-8")
        command = [sys.executable, "-m", "pipenav_hardware.emulator.server", str(file)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            start_new_session=True,
        )  # fmt: skip
        self._answer()

    def order(self, **order: Any) -> None:
        """Have something happen now: a fault by `fault=...`, `clear=True`, `place=[...]`, `plug="bus"`."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        self._answer()

    def close(self) -> None:
        """End the process; its log is complete then."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait(timeout=10)
        for stream in (self._process.stdout, self._process.stderr):
            if stream is not None:
                stream.close()
        self._temporary.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _answer(self) -> None:
        assert self._process.stdout is not None and self._process.stderr is not None
        if not self._process.stdout.readline():
            why = self._process.stderr.read().strip().splitlines()
            raise PipenavError(f"the emulator ended: {why[-1] if why else 'it said nothing'}.")
