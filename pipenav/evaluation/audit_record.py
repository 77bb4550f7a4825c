"""The result of an audit, as written to eval.json. docs/formats/evaluation-folder.md describes the format."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from pipenav.evaluation.audit import AuditRows
from pipenav.evaluation.record import Amount, Count, Record
from pipenav.units import m_to_mm


class AuditRecord(Record):
    """The audit of an evaluation.

    Attributes:
        episodes: successful episodes that were audited.
        allowed_overlap_m: overlap that the task allows [m].
        max_overlap_m: deepest overlap in a recorded pose [m]; None where nothing was audited.
        max_overlap_between_m: deepest overlap between recorded poses, where the motion is drawn and not known [m].
        max_speed_ratio: largest speed of a joint, as a multiple of its motor's no-load speed.
        max_power_ratio: largest share that braking a pushed joint took of the power of all other motors and the weight.
        overlapping: episodes with more overlap than is allowed in a recorded pose.
        pushed: episodes in which a joint was faster than its motor without load.
        too_fast: episodes in which a joint was faster than all motors and the weight together can drive it.
        not_arrived: episodes whose tip was not on the target at the end, or whose tail was not through.
        broken: episodes with any of these.
    """

    episodes: Count
    allowed_overlap_m: Amount
    max_overlap_m: Amount | None = None
    max_overlap_between_m: Amount | None = None
    max_speed_ratio: Amount | None = None
    max_power_ratio: Amount | None = None
    overlapping: Count
    pushed: Count
    too_fast: Count
    not_arrived: Count
    broken: Count

    @classmethod
    def of(cls, parts: Sequence[AuditRows], allowed: float) -> Self:
        """The audits of all parts, counted.

        Args:
            parts: audits of every part.
            allowed: overlap that the task allows [m].
        """
        every = AuditRows(*(np.concatenate(columns) for columns in zip(AuditRows.empty(), *parts, strict=True)))
        overlapping, too_fast, lost = every.overlap > allowed, every.power > 1.0, ~every.arrived
        amounts = every.overlap, every.between, every.speed, every.power
        largest = [float(column.max()) if len(column) else None for column in amounts]
        return cls(
            episodes=len(every.jobs),
            allowed_overlap_m=allowed,
            max_overlap_m=largest[0],
            max_overlap_between_m=largest[1],
            max_speed_ratio=largest[2],
            max_power_ratio=largest[3],
            overlapping=int(overlapping.sum()),
            pushed=int((every.speed > 1.0).sum()),
            too_fast=int(too_fast.sum()),
            not_arrived=int(lost.sum()),
            broken=int((overlapping | too_fast | lost).sum()),
        )

    @property
    def words(self) -> str:
        """The audit in a few lines, for a terminal."""
        if not self.episodes:
            return "audit by geometry: no successful episode was drawn"
        assert self.max_overlap_m is not None
        assert self.max_overlap_between_m is not None
        assert self.max_speed_ratio is not None
        assert self.max_power_ratio is not None
        return (
            f"audit of {self.episodes:,} successful episodes by geometry: {self.broken:,} broken\n"
            f"  overlap over {m_to_mm(self.allowed_overlap_m):g} mm: {self.overlapping:,}, largest "
            f"{m_to_mm(self.max_overlap_m):.2f} mm (on curves drawn between the recorded poses "
            f"{m_to_mm(self.max_overlap_between_m):.2f} mm)\n"
            f"  joints past their motors' no-load speed: {self.pushed:,}, largest {self.max_speed_ratio:.2f} of it\n"
            f"  joints faster than all motors and the weight can drive them: {self.too_fast:,}, largest "
            f"{self.max_power_ratio:.0%} of that power; not arrived: {self.not_arrived:,}"
        )
