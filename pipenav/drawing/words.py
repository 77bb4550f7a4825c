"""Words for what a route is made of, in its drawings."""

from __future__ import annotations

from pipenav.drawing.dimensions import number
from pipenav.pipes.branch import Branch
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner
from pipenav.units import m_to_mm, rad_to_deg


def words_of(corner: Corner, branches: bool = False) -> str:
    """`65° left`, and on lines of their own bend radius, roll, a reducer's bore, and the branches that it passes.

    Args:
        corner: the corner.
        branches: whether every branch is described, where the picture does not do it.
    """
    if corner.reducer and corner.to_diameter is not None:
        shape = f"over {number(m_to_mm(corner.length))}" if corner.length else "in a step"
        return f"to ⌀ {number(m_to_mm(corner.to_diameter))}\n{shape}"
    on = corner.branches and corner.straight_on
    lines = ["straight on" if on else f"{rad_to_deg(corner.angle):g}° {corner.turn}"]
    if corner.bend_radius:
        lines.append(f"R {number(m_to_mm(corner.bend_radius))}")
    if corner.roll and not on:
        lines.append(f"rolled {rad_to_deg(corner.roll):g}°")
    if corner.to_diameter is not None:
        lines.append(f"to ⌀ {number(m_to_mm(corner.to_diameter))}")
    if branches:
        for branch in corner.branches:
            lines += [f"past ⌀ {number(m_to_mm(branch.diameter))}", *side_of(branch)]
    elif corner.branches:
        count = len(corner.branches)
        lines.append("past a branch" if count == 1 else f"past {count} branches")
    return "\n".join(lines)


def side_of(branch: Branch) -> list[str]:
    """Angle and side of a branch and, on a line of its own, its roll."""
    on = Corner(angle=branch.angle).straight_on
    side = "straight on" if on else f"{rad_to_deg(branch.angle):g}° {branch.turn}"
    rolled = [f"rolled {rad_to_deg(branch.roll):g}°"] if branch.roll and not on else []
    return [f"{side}{', capped' if branch.closed else ''}", *rolled]


def size_of(branch: Branch) -> str:
    """Bore and length of a branch, and its cap."""
    size = f"⌀ {number(m_to_mm(branch.diameter))}, {number(m_to_mm(branch.length))} long"
    return f"{size}, capped" if branch.closed else size


def counts_of(route: PipeRoute) -> str:
    """`2 corners, one tee, one reducer, a cap`."""
    kinds = ["reducer" if c.reducer else ("corner", "tee", "cross")[len(c.branches)] for c in route.corners]
    return counted(kinds, ("corner", "tee", "cross", "reducer")) + (", capped" if route.capped else "")


def counted(kinds: list[str], names: tuple[str, ...]) -> str:
    """Count of each name in a list, in words; names that do not come are left out."""
    plural = {"cross": "crosses"}
    found = [(name, kinds.count(name)) for name in names if name in kinds]
    return ", ".join(f"one {name}" if many == 1 else f"{many} {plural.get(name, name + 's')}" for name, many in found)
