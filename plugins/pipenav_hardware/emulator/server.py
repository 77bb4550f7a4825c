"""Program of the emulator's process, whose argument is a file of its configuration.

It prints one line of JSON when it is ready, takes orders as lines of JSON on its standard input, and ends when that
closes. Orders: a fault (see `faults.Fault`), `{"clear": true}`, `{"place": [counts]}`, `{"plug": device}`.
"""

from __future__ import annotations

import contextlib
import gc
import heapq
import json
import math
import os
import select
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.backends import ArmStart
from pipenav.robots import load_robot
from pipenav_hardware import table
from pipenav_hardware.emulator.bus import ServoBus
from pipenav_hardware.emulator.config import EmulatorConfig
from pipenav_hardware.emulator.faults import Fault, FaultScript
from pipenav_hardware.emulator.free_plant import FreePlant
from pipenav_hardware.emulator.line import ByteLog, Line, Send
from pipenav_hardware.emulator.pipe_plant import PipePlant
from pipenav_hardware.emulator.plant import Plant
from pipenav_hardware.emulator.sensors import FrontDevice, Scip2Device
from pipenav_hardware.emulator.servo import EmulatedServo

AFTERLIFE = 1.0
"""Time for which the devices outlive their orders if a servo's torque, or the scanner's laser, is on then [s].

The process that gave the orders may have been killed; real servos would still hear the supervisor, and answer it.
"""

TURNAROUND = 0.002
"""Time before a servo's answer is due for which the servo has the line [s]."""


class _Outgoing(NamedTuple):
    """Bytes that a device is going to send; those that are due first [s] sort first."""

    due: float
    number: int
    device: str
    data: bytes


class Server:
    """Serves all lines in one loop, in which nothing waits but `select`."""

    def __init__(self, config: EmulatorConfig) -> None:
        self.log = ByteLog(config.log)
        self.faults = FaultScript(list(config.settings.faults), config.settings.seed)
        robot = load_robot(config.robot)
        self.plant = _plant(config)
        servos = [
            EmulatedServo(servo.id, servo.count_limits, servo.torque_counts, config.arm.baud)
            for servo in config.arm.servos
        ]
        self.lines = {"bus": Line(Path(config.arm.port)), "scanner": Line(Path(config.arm.scanner.port))}
        if config.arm.front_sensor is not None:
            self.lines["front"] = Line(Path(config.arm.front_sensor.port), hold_open=False)
        self.bus = ServoBus(servos, self.plant, self.faults, self._sender("bus"), config.settings.adapter_latency)
        self.scanner = Scip2Device(robot.laser, self.plant, self.faults, self._sender("scanner"), self.log.event)
        self.front = FrontDevice(self.plant, self.faults, self._sender("front"), config.settings.boot_time)
        self._outgoing: list[_Outgoing] = []
        self._count, self._start, self._orders = 0, time.monotonic(), b""
        self._moment, self._ends = 0.0, math.inf
        self.bus.feel(0.0)
        for servo, shaft in zip(servos, self.plant.shafts(0.0), strict=True):
            servo.power_on(shaft.position)

    def run(self) -> None:
        """Serve until the orders end; then log how it ended, and close everything."""
        while self._turn():
            pass
        if isinstance(self.plant, PipePlant):
            tip = [float(x) for x in self.plant.tip(self._now)]
            force, depth = self.plant.peak_force, self.plant.penetration
            self.log.event("end", tip_m=tip, peak_force_n=force, penetration_m=depth)
        for line in self.lines.values():
            line.unplug()
        self.log.close()

    @property
    def _now(self) -> float:
        return time.monotonic() - self._start

    def _sender(self, device: str) -> Send:
        """A function that sends bytes some time after the moment being dealt with, however long that dealing takes."""

        def send(delay: float, data: bytes) -> None:
            self._count += 1
            heapq.heappush(self._outgoing, _Outgoing(self._moment + delay, self._count, device, data))

        return send

    def _turn(self) -> bool:
        """Wait for bytes or for the next thing to do.

        Returns:
            False when the orders, and what outlives them, have ended.
        """
        due = self._run_devices()
        heard = [line.master for name, line in self.lines.items() if line.plugged and not self._deaf(name)]
        orders_end = self._ends < math.inf
        ready, _, _ = select.select(heard if orders_end else [0, *heard], [], [], max(0.0, min(due - self._now, 0.05)))
        for name, line in self.lines.items():
            if line.plugged and line.master in ready:
                self._receive(name, line)
        if 0 in ready:
            data = os.read(0, 65536)
            *orders, self._orders = (self._orders + data).split(b"\n")
            for order in orders:
                self._obey(json.loads(order))
            if not data:
                self._ends = self._now + (AFTERLIFE if self._holds() or self.scanner.shines else 0.0)
        return self._now < self._ends

    def _holds(self) -> bool:
        """Whether a servo's torque is on."""
        return any(servo.get(table.TORQUE_ENABLE) for servo in self.bus.servos)

    def _deaf(self, name: str) -> bool:
        """Whether a device takes no bytes now."""
        if name == "front":
            return True  # it takes no orders, and a line that nobody has open is always ready
        return name == "bus" and (self.faults.active("deaf") is not None or self._speaks())

    def _speaks(self) -> bool:
        """Whether a servo has the line, as its answer is due.

        Listening would then wait for the kernel's worker thread that delivered the question, and make the answer late.
        """
        return any(out.device == "bus" and out.due - self._now < TURNAROUND for out in self._outgoing[:1])

    def _receive(self, name: str, line: Line) -> None:
        """Log the bytes that have arrived on a line, and hand them to its device."""
        data = line.read()
        if not data:
            return
        now = self._moment = self._now
        self.log.bytes(name, "in", data)
        if name == "bus":
            self.bus.receive(now, data, line.baud)
        else:
            self.scanner.receive(data)

    def _run_devices(self) -> float:
        """Do what is due.

        Returns:
            When something is due next [s].
        """
        now = self.faults.now = self._moment = self._now
        for fault in self.faults.due():
            self.log.event("fault", **fault.model_dump())
            if fault.fault == "unplug":
                self.lines[fault.device].unplug()
            elif fault.device == "scanner":
                self.scanner.begin(fault)
            else:
                self.bus.feel(now)
                self.bus.begin(fault)
                self.bus.command(now)
        due = [now + 0.05]
        if self.lines["scanner"].plugged:
            due.append(self.scanner.run(now))
        if "front" in self.lines and self.lines["front"].plugged:
            due.append(self.front.run(now, self.lines["front"].opened))
        while self._outgoing and self._outgoing[0].due <= self._now:
            _, _, device, data = heapq.heappop(self._outgoing)
            if self.lines[device].plugged:
                self.lines[device].write(data)
                if device == "bus":
                    self.log.bytes(device, "out", data)
        return min(due + [out.due for out in self._outgoing[:1]])

    def _obey(self, order: dict[str, Any]) -> None:
        """Carry out an order, and print that it was."""
        if "clear" in order:
            self.faults.clear()
        elif "place" in order:
            assert isinstance(self.plant, FreePlant)
            self.plant.place(order["place"])
        elif "plug" in order:
            self.lines[order["plug"]].plug()
        else:
            self.faults.add(Fault.model_validate(order))
        self.log.event("order", order=order)
        print(json.dumps({"obeyed": order}), flush=True)


def _plant(config: EmulatorConfig) -> Plant:
    """The mechanics behind the servos: in a pipe, or free."""
    if config.pipe is None:
        return FreePlant(len(config.arm.servos), config.settings.seed)
    from pipenav.backends import open_simulator

    robot = load_robot(config.robot)
    options = {"threads": 1} if config.settings.backend == "mujoco" else {}
    simulator = open_simulator(config.settings.backend, robot, 1, options, len(config.pipe.segments))
    q = np.zeros(len(robot.joints)) if config.q is None else np.array(config.q)
    return PipePlant(robot, config.arm, simulator, config.pipe, ArmStart(q, config.base))


def main(arguments: Sequence[str]) -> None:
    server = Server(EmulatorConfig.model_validate_json(Path(arguments[0]).read_text()))
    gc.collect()
    gc.freeze()  # to look through all of the simulator's objects takes 24 ms, in which no servo would answer
    print(json.dumps({"ready": {name: str(line.path) for name, line in server.lines.items()}}), flush=True)
    with contextlib.suppress(BrokenPipeError):
        server.run()
