"""Certificates as JSON files, which another program, or `pipenav certify --check`, can check from scratch."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

import pipenav
from pipenav.arrays import Floats
from pipenav.certify.arm import Ends
from pipenav.certify.model import Model
from pipenav.certify.motion_check import check_by_distance, check_by_shapely
from pipenav.certify.verdict import Kind, Verdict, certify, timed
from pipenav.certify.whole_motion import tail_is_through
from pipenav.errors import ConfigError, PipenavError
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.motions.trajectory_file import read_trajectory, write_trajectory
from pipenav.pipes.json_keys import PipeInFile
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import read_json, shown_path
from pipenav.tasks.outcome import PassageStage
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.units import m_to_mm, mm_to_m, rad_to_deg

Pair = Annotated[tuple[float, float], Field(strict=False)]
Names = Annotated[tuple[str, ...], Field(strict=False)]
Numbers = Annotated[tuple[float, ...], Field(strict=False)]


class CertificateError(PipenavError):
    """A certificate that does not hold."""

    def __init__(self, path: Path, problem: str, remedy: str = "certify the pipe again") -> None:
        super().__init__(f"certificate {shown_path(path)} {problem}: {remedy}.")


class ProofInFile(BaseModel):
    """Proof of an impossible pipe.

    Attributes:
        links: names of the links that cannot pass.
        headings_deg: headings of a single link at which the pipe has no room; empty where cells were searched.
        finest_deg: width of the smallest cells.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    links: Names
    headings_deg: Numbers
    finest_deg: float


class EndsInFile(BaseModel):
    """Starts and targets of an arm, in metres and radians, as `pipenav.certify.arm.Ends` describes them."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    slide: Pair
    start_slide: Pair
    start_headings: Numbers
    along: Pair
    left: Pair
    aim_along: Pair
    aim_left: Pair
    tolerance: float
    base: float
    start: Numbers

    @classmethod
    def of(cls, ends: Ends) -> EndsInFile:
        """The ends with lists in place of arrays."""
        plain = {
            name: v.tolist() if isinstance(v, np.ndarray) else v
            for name, v in ends._asdict().items()
            if name != "further"
        }
        return cls(**plain)

    @property
    def ends(self) -> Ends:
        """The ends with arrays."""
        plain = self.model_dump()
        return Ends(**plain | {name: np.array(plain[name]) for name in ("start_headings", "start")})


class Certificate(BaseModel):
    """Certificate of one pipe or episode.

    Attributes:
        schema_version: version of the format; the key is `schema`.
        version: version of pipenav that wrote it.
        robot: name of the robot.
        robot_sha256: hash of its description.
        pipe: the pipe, under the keys of pipe.json.
        bore: `plane` or `round`.
        overlap_mm: overlap with the wall that is allowed [mm].
        ends: starts and targets of an arm; None for a whole robot.
        resolution_deg: width of the smallest cells that were allowed [deg].
        verdict: passable, impossible or undecided.
        reason: why, in words.
        proof: proof where it is impossible.
        motion: name of the trajectory file beside this one, where it is passable.
        motion_sha256: hash of that file.
        sha256: hash of all the other keys.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)

    schema_version: Literal[1] = Field(1, alias="schema")
    version: str
    robot: str
    robot_sha256: str
    pipe: PipeInFile
    bore: Literal["plane", "round"]
    overlap_mm: float
    ends: EndsInFile | None = None
    resolution_deg: float
    verdict: Kind
    reason: str
    proof: ProofInFile | None = None
    motion: str | None = None
    motion_sha256: str | None = None
    sha256: str = ""

    @property
    def digest(self) -> str:
        """Hash of all keys but the hash itself."""
        content = self.model_dump(mode="json", by_alias=True, exclude={"sha256"})
        return _sha256(json.dumps(content, sort_keys=True).encode())


class Certified(NamedTuple):
    """A pipe with its verdict.

    Attributes:
        model: what was certified.
        ends: starts and targets of an arm.
        resolution: width of the smallest cells [rad].
        verdict: the verdict.
    """

    model: Model
    ends: Ends | None
    resolution: float
    verdict: Verdict


def write_certificate(folder: Path, name: str, certified: Certified) -> Path:
    """Write `<name>.json`, and `<name>.csv` with the motion of a passable pipe.

    Raises:
        FileProblem: a file cannot be written.
    """
    model, ends, resolution, verdict = certified
    motion = folder / f"{name}.csv" if verdict.motion is not None else None
    if motion is not None:
        write_trajectory(motion, trajectory(certified))
    proof = verdict.proof and ProofInFile(
        links=verdict.proof.links,
        headings_deg=tuple(map(rad_to_deg, verdict.proof.headings)),
        finest_deg=rad_to_deg(verdict.proof.finest),
    )
    certificate = Certificate(
        version=pipenav.__version__,
        robot=model.robot.name,
        robot_sha256=robot_hash(model.robot),
        pipe=model.pipe,
        bore="plane" if model.bore == "plane" else "round",
        overlap_mm=m_to_mm(model.overlap),
        ends=None if ends is None else EndsInFile.of(ends),
        resolution_deg=rad_to_deg(resolution),
        verdict=verdict.kind,
        reason=verdict.reason,
        proof=proof,
        motion=None if motion is None else motion.name,
        motion_sha256=None if motion is None else _sha256(motion.read_bytes()),
    )
    certificate = certificate.model_copy(update={"sha256": certificate.digest})
    text = json.dumps(certificate.model_dump(mode="json", by_alias=True), indent=2)
    atomic_write(folder / f"{name}.json", text + "\n")
    return folder / f"{name}.json"


def trajectory(certified: Certified) -> Trajectory:
    """The motion of a passable pipe as a trajectory that `pipenav view` and `pipenav mirror-rear` take."""
    model, ends, _, verdict = certified
    assert verdict.motion is not None
    q = timed(model, verdict.motion)
    pipe = model.pipe.with_ends(*[_reach(model, q, verdict.base)] * 2)
    goal = None
    if ends is not None:
        tip = kinematics.forward(model.robot, q[-1:]).tip[0]
        goal = (float(tip[0] + verdict.base), float(tip[1]))
    stage = PassageStage.TRAVERSE if model.robot.free else PassageStage.REACH
    header = TrajectoryHeader(
        robot=model.robot.name,
        pipe=pipe,
        base_m=verdict.base,
        goal_m=goal,
        stage=stage,
        outcome="reached",
        controller="certify",
    )
    return Trajectory(header, model.robot, q)


def _reach(model: Model, q: Floats, base: float) -> float:
    points = frames.robot_to_pipe(kinematics.waypoints(model.robot, q), base)
    return math.ceil(100 * float(np.hypot(points[..., 0], points[..., 1]).max()) + 1) / 100


NO_SHAPES = frozenset({"name", "mass", "friction", "friction_source", "limit_source", "actuator"})
"""Keys of a robot's links, joints and wheels that say nothing of shapes or joint limits."""


def robot_hash(robot: RobotSpec) -> str:
    """Hash of a robot's description."""
    return _sha256(json.dumps(robot.model_dump(mode="json"), sort_keys=True).encode())


def shape_hash(robot: RobotSpec) -> str:
    """Hash of what certificates know of a robot: shapes and joint limits, and neither masses, motors nor friction."""

    def kept(value: object) -> object:
        if isinstance(value, dict):
            return {key: kept(inner) for key, inner in value.items() if key not in NO_SHAPES}
        return [kept(inner) for inner in value] if isinstance(value, list | tuple) else value

    return _sha256(json.dumps(kept(robot.model_dump(mode="json")["links"]), sort_keys=True).encode())


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def read_certificate(path: Path) -> Certificate:
    """A certificate, with the hash of its content checked.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no certificate.
        CertificateError: it was edited.
    """
    content = read_json(path)
    try:
        certificate = Certificate.model_validate(content)
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error) from error
    if certificate.digest != certificate.sha256:
        raise CertificateError(path, "was edited: its content does not have the hash that it names")
    return certificate


def check_certificate(path: Path, robot: RobotSpec) -> Certificate:
    """Check a certificate from scratch: its motion by both tests, or its proof by finding it again.

    Args:
        path: the certificate's file.
        robot: the robot that it must be of.

    Raises:
        CertificateError: it was edited, is of another robot, or does not hold.
    """
    certificate = read_certificate(path)
    if robot.name != certificate.robot or robot_hash(robot) != certificate.robot_sha256:
        raise CertificateError(path, f"is not of this robot {robot.name!r}", "certify the robot as it is now")
    model = Model(robot, certificate.pipe.require_corner(), certificate.bore, mm_to_m(certificate.overlap_mm))
    if certificate.verdict == "passable":
        _check_motion(path, certificate, model)
    if certificate.verdict == "impossible":
        ends = None if certificate.ends is None else certificate.ends.ends
        found = certify(model, ends, math.radians(certificate.resolution_deg))
        if found.kind != "impossible":
            raise CertificateError(path, f"does not hold: the pipe is {found.kind}")
    return certificate


def _check_motion(path: Path, certificate: Certificate, model: Model) -> None:
    motion = path.with_name(str(certificate.motion))
    found = read_trajectory(motion, model.robot)
    if _sha256(motion.read_bytes()) != certificate.motion_sha256:
        raise CertificateError(path, f"does not hold: its motion {motion.name} was edited")
    q, base = found.q, found.header.base_m
    if not check_by_distance(model, q, base).free or not check_by_shapely(model, q, base).free:
        raise CertificateError(path, f"does not hold: its motion {motion.name} touches a wall")
    ends = certificate.ends
    if ends is None:
        arrived = tail_is_through(model, q, TraverseConfig(kind="traverse"))
    else:
        arrived = _tip_on_target(model, ends.ends, q[-1:], base)
    if not arrived:
        raise CertificateError(path, f"does not hold: its motion {motion.name} does not arrive")


def _tip_on_target(model: Model, ends: Ends, q: Floats, base: float) -> bool:
    """Whether the tip is within the tolerance of a target."""
    tip = kinematics.forward(model.robot, q).tip[0] * [1.0, model.pipe.turn_sign] + [base, 0.0]
    axis = np.array([math.cos(model.turn), math.sin(model.turn)])
    at = np.array([tip @ axis, tip @ [-axis[1], axis[0]]])
    nearest = np.clip(at, [ends.aim_along[0], ends.aim_left[0]], [ends.aim_along[1], ends.aim_left[1]])
    return bool(np.hypot(*(at - nearest)) <= ends.tolerance)
