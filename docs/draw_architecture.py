"""Draw docs/architecture.png: python docs/draw_architecture.py

Floors come from the table in docs/architecture.md, arrows from the imports in pipenav/. The imports are also written
into the picture's metadata, so that a test can tell a picture that is out of date.
"""

from __future__ import annotations

import ast
import io
import re
from collections.abc import Iterator
from pathlib import Path

DOCS = Path(__file__).resolve().parent
CORE = DOCS.parent / "pipenav"
PICTURE = DOCS / "architecture.png"

WIDTH, FLOOR_HEIGHT = 11.0, 0.95
"""Size of the picture, and of one floor [in]."""

LEFT = {
    "cli": 9.0,
    "experiments": 1.9,
    "tuning": 4.6,
    "learning": 1.9,
    "recording": 4.5,
    "certify": 5.3,
    "survey": 6.2,
    "portable": 7.6,
    "driving": 8.6,
    "evaluation": 2.5,
    "deployment": 8.6,
    "comparison": 10.2,
    "envs": 1.4,
    "motions": 3.75,
    "policies": 9.6,
    "export": 0.6,
    "disturbances": 3.13,
    "tasks": 6.1,
    "locating": 8.15,
    "testing": 9.45,
    "drawing": 2.38,
    "backends": 6.1,
    "networks": 7.8,
    "pages": 9.6,
    "pipes": 2.6,
    "robots": 5.8,
    "jobs": 10.2,
    "storage": 7.0,
    "processes": 9.3,
    "units": 2.4,
    "arrays": 4.8,
    "errors": 8.0,
}
"""Distance of each package's box from the left [in], chosen so that hardly an arrow runs behind a box."""

Edges = set[tuple[str, str]]
"""Pairs of packages: the first imports the second."""


def floors() -> list[list[str]]:
    """The packages of each floor, the lowest floor first, as the table says."""
    rows = re.findall(r"^\| (\d+) \| `(\w+)` \|", (DOCS / "architecture.md").read_text(encoding="utf-8"), re.MULTILINE)
    return [[name for number, name in rows if int(number) == floor] for floor in range(1, int(rows[-1][0]) + 1)]


def imports() -> Edges:
    """Every import of one package of pipenav by another."""
    known = {name for floor in floors() for name in floor}
    edges = set()
    for path in CORE.rglob("*.py"):
        package = path.relative_to(CORE).with_suffix("").parts[0]
        edges |= {(package, name) for name in _imported(ast.parse(path.read_text(encoding="utf-8"))) if name != package}
    return {(one, other) for one, other in edges if {one, other} <= known}


def _imported(node: ast.AST) -> Iterator[str]:
    """Packages of pipenav that a piece of code imports, where it runs."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            continue
        if isinstance(child, ast.ImportFrom) and child.module == "pipenav":
            yield from (alias.name for alias in child.names)
        elif isinstance(child, ast.ImportFrom) and (child.module or "").startswith("pipenav."):
            yield str(child.module).split(".")[1]
        elif isinstance(child, ast.Import):
            yield from (a.name.split(".")[1] for a in child.names if a.name.startswith("pipenav."))
        yield from _imported(child)


def needed(edges: Edges) -> Edges:
    """The edges that do not follow from others."""
    below: dict[str, set[str]] = {}
    for one, other in edges:
        below.setdefault(one, set()).add(other)

    def reachable(name: str) -> set[str]:
        return below.get(name, set()).union(*(reachable(other) for other in below.get(name, ())))

    return {(one, other) for one, other in edges if not any(other in reachable(via) for via in below[one] - {other})}


def as_text(edges: Edges) -> str:
    """Edges as one line, for the picture's metadata."""
    return " ".join(f"{one}>{other}" for one, other in sorted(edges))


def draw() -> None:
    """Write the picture."""
    from matplotlib.figure import Figure
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    edges, levels = imports(), floors()
    at = {name: (LEFT[name], i * FLOOR_HEIGHT) for i, names in enumerate(levels) for name in names}
    figure = Figure(figsize=(WIDTH, len(levels) * FLOOR_HEIGHT), dpi=110)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.45, WIDTH), ylim=(-0.55, (len(levels) - 0.45) * FLOOR_HEIGHT))
    axes.axis("off")
    for number in range(len(levels)):
        y = number * FLOOR_HEIGHT
        axes.axhspan(y - 0.36, y + 0.36, color="#eef2f6" if number % 2 else "#f7f9fb", zorder=0)
        axes.text(-0.3, y, str(number + 1), fontsize=13, color="#66717c", ha="center", va="center")
    for one, other in sorted(needed(edges)):
        (x, y), (below_x, below_y) = at[one], at[other]
        style = {"arrowstyle": "-|>", "color": "#7a8896", "lw": 1.1, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
        axes.annotate("", (below_x, below_y + 0.2), (x, y - 0.2), arrowprops=style, zorder=1)
    for name, (x, y) in at.items():
        box = {"boxstyle": "round,pad=0.45", "facecolor": "white", "edgecolor": "#0072b2", "linewidth": 1.4}
        axes.text(x, y, name, fontsize=11, family="monospace", ha="center", va="center", bbox=box, zorder=3)
    drawn, text = io.BytesIO(), PngInfo()
    figure.savefig(drawn, format="png")
    text.add_text("Imports", as_text(edges))
    Image.open(drawn).convert("RGB").quantize(64).save(PICTURE, optimize=True, pnginfo=text)


if __name__ == "__main__":
    draw()
    print(f"written: {PICTURE}")
