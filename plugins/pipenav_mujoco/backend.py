"""n robots in the plane on MuJoCo's batch: one model, walls placed for each robot, beams once a control step."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Annotated

import mujoco
import mujoco.batch
import numpy as np
from pydantic import Field, field_validator

from pipenav.arrays import Floats, Ints
from pipenav.backends import (
    BackendOptions,
    Command,
    Control,
    Reading,
    Simulator,
    Truth,
    Variation,
    Windows,
    physics_steps,
    strongest,
    wall_boxes,
)
from pipenav.pipes import Pipe
from pipenav.robots import BASE, RobotSpec, kinematics, laser
from pipenav_mujoco.model import Contact, build_spec, compiled
from pipenav_mujoco.space import MujocoSpace
from pipenav_mujoco.space_batch import SpaceSettings
from pipenav_mujoco.viewer import FROM_ABOVE, Marks, MujocoViewer

Impedance = Annotated[float, Field(ge=1e-4, le=0.9999)]
"""Impedance of a contact; MuJoCo itself clips it to this range (mjMINIMP, mjMAXIMP)."""


class MujocoOptions(BackendOptions):
    """Settings of the MuJoCo backend."""

    timestep: float = Field(0.0025, ge=1e-4, le=0.01, description="physics step [s]; must divide the control period")
    threads: int = Field(0, ge=0, le=1024, description="threads that step the robots; 0 uses every core")
    contact_time_constant: float = Field(0.005, ge=1e-4, le=0.1, description="solref time constant of contacts [s]")
    gravity: float | None = Field(
        None, ge=0, le=20, description="gravity downwards in routes that leave the plane [m/s^2]; default: the task's"
    )
    contact_impedance: tuple[Impedance, Impedance, Annotated[float, Field(ge=1e-9, le=1)]] = Field(
        (0.95, 0.99, 0.001), strict=False, description="solimp d0, d_width [1] and width [m] of contacts"
    )

    @field_validator("timestep")
    @classmethod
    def _divides_the_control_period(cls, timestep: float) -> float:
        physics_steps(timestep)
        return timestep


class MujocoBackend(Simulator):
    """Simulator of n robots in the plane, see `pipenav.backends.Simulator`."""

    Options = MujocoOptions
    moves_in_space = steps_in_threads = robots_are_independent = True
    can_vary = can_incline = can_pull = has_viewer = True

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:
        assert isinstance(options, MujocoOptions)
        self._robot = robot
        self._slots = wall_segments
        self._substeps = physics_steps(options.timestep)
        contact = Contact(options.contact_time_constant, options.contact_impedance)
        self._model = compiled(build_spec(robot, wall_segments, options.timestep, contact), robot)
        self._batch = mujoco.batch.Batch(self._model, n, options.threads)
        self._segments = np.full((2, 2, wall_segments, n), np.inf).T  # robots last in memory: see laser.cast
        self._base = np.zeros(n)
        self._control: Control | None = None
        self._moved = False
        self._pose: kinematics.ChainPose | None = None
        self._stiffness = np.tile([actuator.controller_gain for actuator in robot.driven_actuators], (n, 1))
        self._effort = np.tile(robot.effort_limits, (n, 1))
        self._bind(n)

    @classmethod
    def in_space(cls, robot: RobotSpec, n: int, options: BackendOptions) -> MujocoSpace:
        assert isinstance(options, MujocoOptions)
        physics_steps(options.timestep)
        contact = Contact(options.contact_time_constant, options.contact_impedance)
        return MujocoSpace(robot, n, SpaceSettings(options.timestep, contact, options.gravity, options.threads))

    def _bind(self, n: int) -> None:
        """Bind live views of the batch's state, and allocate the record of the physics steps."""
        batch, model, robot = self._batch, self._model, self._robot
        self._state, self._speeds, self._time = batch.bind("qpos"), batch.bind("qvel"), batch.bind("time")
        # Every joint has one coordinate here, so indices into qpos and into qvel are the same.
        joints = [model.joint(joint.name).qposadr[0] for joint in robot.joints]
        base = [model.joint(f"base_{name}").qposadr[0] for name in BASE if robot.free]
        self._joints, self._configured = np.array(joints, int), np.array(base + joints, int)
        self._wheels = np.array([model.joint(wheel.name).qposadr[0] for wheel in robot.wheels], int)
        self._asked, self._loads = batch.bind("actuator_force"), np.zeros((n, len(robot.driven_actuators)))
        self._ctrl, self._warm = batch.bind("ctrl"), batch.bind("qacc_warmstart")
        self._applied = batch.bind("xfrc_applied")  # (n, bodies, 6): forces at the centres of mass, then torques
        self._pulled = np.zeros((n, 2))
        self._wall_position, self._wall_quaternion = batch.bind("mocap_pos"), batch.bind("mocap_quat")
        first = model.geom("wall0").id
        self._longest_walls = model.geom_size[first : first + self._slots].copy()
        self._wall_half_size = batch.expand("geom_size")[:, first : first + self._slots]
        self._gain, self._bias = batch.expand("actuator_gainprm"), batch.expand("actuator_biasprm")
        self._record = {"sensordata": np.zeros((n, self._substeps, model.nsensordata))}
        self._depth, self._contact_share = np.zeros(n), np.zeros(n)
        self._link_forces = np.zeros((n, len(robot.links), 2))
        self._wheel_links = np.array([i for i, link in enumerate(robot.links) if link.wheel], int)
        self._ranges = np.zeros((n, robot.laser.beams))
        self._masses = np.tile(model.body_mass, (n, 1))
        self._windows = Windows(self._substeps, model.opt.timestep)

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        self._sense()
        walls = wall_boxes(pipes, self._slots, base)
        self._wall_position[indices], self._wall_quaternion[indices] = walls.position, walls.quaternion
        self._wall_half_size[indices], self._segments[indices] = walls.half_size, walls.segments
        self._base[indices] = base
        for values in (self._state, self._speeds, self._time, self._warm, self._loads):
            values[indices] = 0.0
        self._state[np.ix_(indices, self._configured)] = q
        self._depth[indices], self._contact_share[indices], self._link_forces[indices] = 0.0, 0.0, 0.0
        self._pose = None
        self._ranges[indices] = self._scan(kinematics.forward(self._robot, q), walls.segments)
        return self._reading(indices)

    def step(self, command: Command) -> None:
        if command.control != self._control:
            self._control = command.control
            self._set_gains(slice(None))
        self._ctrl[:] = command.values
        self._batch.rollout(self._substeps, record=("sensordata",), out=self._record)
        self._moved = True

    def _sense(self) -> None:
        """Compute what the sensors and the contacts of the last control step come to, where that is not done yet.

        A step leaves it to whoever reads first, since steps may run in a thread beside the rest.
        """
        if not self._moved:
            return
        self._moved = False
        self._pose, self._loads = None, self._asked / self._effort
        self._ranges = self._scan(self._own_pose(), self._segments)
        sensors = self._record["sensordata"]  # (n, substeps, 3 per link and wheel + 1)
        distance = np.ascontiguousarray(sensors[:, :, -1].T)  # of the deepest contact, 0 where there is none
        self._depth = np.maximum(-distance.min(axis=0), 0.0)
        self._contact_share = (distance < 0).sum(axis=0) / self._substeps
        touching, links = np.flatnonzero(self._depth), len(self._robot.links)
        shape = len(touching), self._windows.count, links + len(self._wheels), 3
        means = self._windows.means(sensors[touching])[..., :-1].reshape(shape)[..., :2]
        forces = means[:, :, :links].copy()
        forces[:, :, self._wheel_links] += means[:, :, links:]  # a wheel's force is its link's
        self._link_forces = np.zeros_like(self._link_forces)
        self._link_forces[touching] = -strongest(forces)  # the sensors give what the link does to the wall

    def _set_gains(self, indices: slice | Ints) -> None:
        """Make the actuators of some robots servos or plain motors; both share the motor's torque-speed line."""
        servo = self._control == "position"
        joints = len(self._joints)
        self._gain[indices, :, 0] = self._stiffness[indices] if servo else self._effort[indices]
        feedback = -self._stiffness[indices] if servo else np.zeros_like(self._stiffness[indices])
        self._bias[indices, :joints, 1], self._bias[indices, joints:, 2] = feedback[:, :joints], feedback[:, joints:]

    def incline(self, indices: Ints, gravity: Floats) -> None:
        moving = np.flatnonzero(self._model.body_mocapid < 0)
        self._applied[indices] = 0.0
        weights = self._masses[np.ix_(indices, moving)][..., None] * gravity[:, None]
        self._applied[np.ix_(indices, moving, np.arange(2))] = weights
        self._pulled[indices] = 0.0

    def pull(self, forces: Floats) -> None:
        first = self._model.body(self._robot.links[0].name).id
        heading = self._own_pose().headings[:, 0]
        arm = -self._model.body_ipos[first, 0] * np.stack([np.cos(heading), np.sin(heading)], axis=1)  # to the rear end
        self._applied[:, first, :2] += forces - self._pulled
        self._applied[:, first, 5] = arm[:, 0] * forces[:, 1] - arm[:, 1] * forces[:, 0]
        self._pulled[:] = forces

    def vary(self, indices: Ints, variation: Variation) -> None:
        """Vary some robots. The fields that it changes become separate for each robot at the first call."""
        batch, model = self._batch, self._model
        links = [model.body(link.name).id for link in self._robot.links]
        rows = np.ix_(indices, links)
        self._masses[rows] = model.body_mass[links] * variation.mass
        batch.expand("body_mass")[rows] = self._masses[rows]
        batch.expand("body_inertia")[rows] = model.body_inertia[links] * variation.mass[..., None]
        batch.expand("geom_friction")[indices, :, 0] = model.geom_friction[:, 0] * variation.friction[:, None]
        self._derive_constants(indices)
        self._effort[indices] = self._robot.effort_limits * variation.strength
        stiffness = [actuator.controller_gain for actuator in self._robot.driven_actuators]
        self._stiffness[indices] = stiffness * variation.strength * variation.gain
        batch.expand("actuator_forcerange")[indices] = np.stack(
            [-self._effort[indices], self._effort[indices]], axis=-1
        )
        self._set_gains(indices)

    def _derive_constants(self, indices: Ints) -> None:
        """Let MuJoCo derive its constants from the masses of some robots.

        Bounding volumes must stay those of the longest walls: a reset changes walls without computing them anew.
        """
        walls = self._wall_half_size[indices]
        self._wall_half_size[indices] = self._longest_walls
        self._batch.set_const(indices)
        self._wall_half_size[indices] = walls

    def read(self) -> Reading:
        self._sense()
        return self._reading(slice(None))

    def _reading(self, indices: Ints | slice) -> Reading:
        state, speeds = self._state[indices], self._speeds[indices]
        wheels = speeds[:, self._wheels] if self._robot.wheels else None
        ranges, time, loads = (values[indices].copy() for values in (self._ranges, self._time, self._loads))
        return Reading(state[:, self._joints], speeds[:, self._joints], ranges, time, wheels, loads)

    def _own_pose(self) -> kinematics.ChainPose:
        """Pose of all robots now, computed once after each step."""
        if self._pose is None:
            self._pose = kinematics.forward(self._robot, self._state[:, self._configured])
        return self._pose

    def _scan(self, pose: kinematics.ChainPose, segments: Floats) -> Floats:
        beams = pose.headings[:, -1:] + self._robot.laser.angles
        return laser.measure(self._robot.laser, laser.cast(pose.tip, beams, segments))

    def truth(self) -> Truth:
        self._sense()
        pose = self._own_pose()
        tip = np.concatenate([pose.tip, pose.headings[:, -1:]], axis=1)
        tip[:, 0] += self._base
        force = np.sqrt((self._link_forces**2).sum(axis=2)).max(axis=1)
        return Truth(tip, force, self._depth.copy(), self._contact_share.copy(), self._link_forces.copy())

    def open_viewer(self) -> MujocoViewer:
        """Open MuJoCo's own viewer on the first robot; its walls stay as they are now."""
        model = copy.copy(self._model)
        first = model.geom("wall0").id
        model.geom_size[first : first + self._slots] = self._wall_half_size[0]
        live = {"qpos": self._state, "qvel": self._speeds, "ctrl": self._ctrl}
        walls = {"mocap_pos": self._wall_position, "mocap_quat": self._wall_quaternion}
        states = {name: values[0] for name, values in (live | walls).items()}
        return MujocoViewer(model, states, self._marks, FROM_ABOVE)

    def _marks(self) -> Marks:
        """Beams and forces of the first robot."""
        self._sense()
        pose, lengths = self._own_pose(), self._robot.lengths[:, None]
        beams = pose.headings[0, -1] + self._robot.laser.angles
        ends = pose.tip[0] + self._ranges[0, :, None] * np.stack([np.cos(beams), np.sin(beams)], axis=1)
        along = np.stack([np.cos(pose.headings[0]), np.sin(pose.headings[0])], axis=1)
        middles = pose.joints[0] + lengths / 2 * along
        tip, ends, middles, forces = (
            np.pad(part, [(0, 0)] * (part.ndim - 1) + [(0, 1)])
            for part in (pose.tip[0], ends, middles, self._link_forces[0])
        )
        return Marks(tip, ends, middles, forces, float(self._base[0]))

    def close(self) -> None:
        self.__dict__.pop("_batch", None)
