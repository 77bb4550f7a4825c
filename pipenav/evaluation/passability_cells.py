"""Cells of map.png where geometry has decided: verdicts as hatching and words, training as a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Self

from pipenav.drawing.style import INK
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.passability_record import Chances
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.summary import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

IMPOSSIBLE, UNDECIDED = "////", "..."
"""Hatching of cells with episodes that were impossible, or, which is drawn first, that are not decided."""

BARE = "#e9ecef"
"""Colour of cells without a possible episode: grey is no colour of the scale of success."""

LINES = "#7d8892"
"""Colour of hatching: darker than every cell that it lies on, lighter than the words over it."""

GAP = "#c8511b"
"""Colour of gaps in the legend: that of a success of 40 %."""

WHOLLY = {"impossible": "impossible", "overlap": "only overlap", "undecided": "undecided"}
"""Words for cells whose episodes were all of one kind."""

Place = tuple[int, int]
"""Row and column of a cell."""


class CertifiedCell(NamedTuple):
    """Pipes of one cell together.

    Attributes:
        chances: their episodes by the chance that geometry gave them.
        trained: whether all of them lie inside of the policy's training; None where that is not known.
    """

    chances: Chances
    trained: bool | None

    @classmethod
    def of(cls, records: Sequence[PipeRecord]) -> Self | None:
        """The cell of some pipes; None where geometry was not asked about them."""
        certified = [record.passability for record in records if record.passability is not None]
        known = [record.trained for record in records if record.trained is not None]
        return cls(Chances.of(certified), all(known) if known else None) if certified else None

    @property
    def bare(self) -> bool:
        """Whether no episode was possible."""
        return self.chances.possible == 0

    @property
    def hatch(self) -> str:
        """Hatching of the cell; empty where all episodes were possible."""
        chances = self.chances
        if chances.possible_with_overlap + chances.undecided:
            return UNDECIDED
        return IMPOSSIBLE if chances.impossible else ""

    @property
    def words(self) -> str:
        """Kinds of the episodes that failed, with their counts; empty where none did."""
        chances = self.chances
        kinds = {
            "gap": chances.gaps,
            "impossible": chances.impossible,
            "overlap": chances.possible_with_overlap,
            "undecided": chances.undecided,
        }
        found = {kind: count for kind, count in kinds.items() if count}
        if self.bare and len(found) == 1:
            return WHOLLY[next(iter(found))]
        if len(found) == 1:
            ((kind, count),) = found.items()
            return f"{count} {kind}{'s' if kind == 'gap' and count > 1 else ''}"
        return ", ".join(f"{count} {kind[:3]}" for kind, count in found.items())

    def draw(self, axes: Axes, at: Place, face: str, ink: str) -> None:
        """Draw it over a cell of a map.

        Args:
            axes: the map, whose cells are one wide and one high, their middles at (column, row).
            at: row and column of the cell.
            face: colour of the cell, behind the words.
            ink: colour of the words.
        """
        from matplotlib.patches import Rectangle
        from matplotlib.patheffects import withStroke

        row, column = at
        if self.hatch:
            axes.add_patch(
                Rectangle(
                    (column - 0.5, row - 0.5), 1, 1, facecolor=face, edgecolor=LINES, hatch=self.hatch, linewidth=0
                )
            )
        if self.trained is False:
            frame = Rectangle((column - 0.45, row - 0.44), 0.9, 0.88, fill=False, edgecolor=ink, linestyle=":")
            axes.add_patch(frame)
        chances = self.chances
        low, high = wilson(chances.successes, chances.episodes)
        lines = (
            (-0.2, percent(chances.successes / chances.episodes, 0), 9.0),
            (0.08, f"{percent(low, 0)}–{percent(high, 0)}", 6.0),
            (0.3, self.words, 6.0),
        )
        for below, text, size in lines:
            drawn = axes.text(column, row + below, text, ha="center", va="center", fontsize=size, color=ink)
            if self.hatch:
                drawn.set_path_effects([withStroke(linewidth=2.5, foreground=face)])


def legend(figure: Figure, cells: Sequence[CertifiedCell]) -> None:
    """Explain below a map the marks that it has."""
    from matplotlib.patches import Patch

    hatches, gaps = {cell.hatch for cell in cells}, any(cell.chances.gaps for cell in cells)
    marks = {
        "failed although possible: a gap of the policy": (gaps, {"facecolor": GAP, "edgecolor": "none"}),
        "with episodes that were impossible": (
            IMPOSSIBLE in hatches,
            {"facecolor": BARE, "edgecolor": LINES, "hatch": IMPOSSIBLE},
        ),
        "with episodes that are undecided, or possible only with overlap": (
            UNDECIDED in hatches,
            {"facecolor": BARE, "edgecolor": LINES, "hatch": UNDECIDED},
        ),
        "outside of the policy's training": (
            any(cell.trained is False for cell in cells),
            {"facecolor": "white", "edgecolor": INK, "linestyle": ":"},
        ),
    }
    patches = [Patch(label=label, **look) for label, (there, look) in marks.items() if there]  # type: ignore[arg-type]
    if patches:
        figure.legend(handles=patches, loc="outside lower left", ncols=2, fontsize=8, frameon=False, labelcolor=INK)
