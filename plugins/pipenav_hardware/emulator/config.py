"""The settings of an emulated arm, and what its process is started with."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from pipenav.arrays import Table
from pipenav.pipes import PipeCorner
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.emulator.faults import Fault
from pipenav_hardware.emulator.sensors import BOOT_TIME


class EmulatorSettings(Table):
    """Settings of an emulated arm: its build, and what goes wrong with it."""

    backend: str = Field("mujoco", description="simulator that moves the arm in its pipe")
    seed: int = Field(0, description="seed of noise and of random faults")
    faults: tuple[Fault, ...] = Field((), strict=False, description="script of faults")
    adapter_latency: float = Field(0.001, ge=0, le=0.1, description="latency of the USB adapter, per answer [s]")
    boot_time: float = Field(BOOT_TIME, ge=0, description="how long the front sensor is deaf after opening [s]")
    front_sensor: bool = Field(True, description="whether there is a front sensor")
    mounted: ArmConfig | None = Field(None, description="how the servos are mounted; ideally where nothing is given")


class EmulatorConfig(Table):
    """Content of the file that the emulator's process reads."""

    robot: str = Field(description="name of the robot")
    arm: ArmConfig = Field(description="how the servos are really mounted; its ports are links that appear")
    settings: EmulatorSettings
    pipe: PipeCorner | None = Field(None, description="the pipe around the arm; without one nothing is around it")
    q: tuple[float, ...] | None = Field(None, strict=False, description="joint positions at the start [rad or m]")
    base: float = Field(0.0, description="where the robot's frame starts on the first leg's axis [m]")
    log: Path = Field(strict=False, description="file for every byte on the lines")
