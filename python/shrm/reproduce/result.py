"""What a reproduction of a table or figure is: rows of numbers, and a picture, written beside each other."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from shrm.environment import Environment

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = str | int | float | None


@dataclass(frozen=True)
class Settings:
    """What the reproductions are made from.

    Attributes
    ----------
    env : Environment
        The light.
    env_name : str
        How the light is called in titles.
    fits : Path or None
        A folder with published fits to measured materials (`merl_abc_low2012.json`, ...).
    quick : bool
        Fewer rows and samples: to see that everything runs.
    """

    env: Environment
    env_name: str
    fits: Path | None = None
    quick: bool = False


@dataclass(frozen=True)
class Result:
    """One table or figure made again.

    Attributes
    ----------
    name : str
        "table-4", "figure-6": the stem of its files.
    title : str
        What it shows, one line.
    columns : sequence of str
        Headings; those of the paper's own figures end in "[RH02]".
    rows : sequence of sequences
        Cells, None where there is nothing to compare with.
    notes : sequence of str
        What was done otherwise than in the paper, and why; what the numbers mean. One sentence or two each.
    figure : matplotlib Figure or None
        The picture.
    """

    name: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()
    figure: Figure | None = field(default=None, compare=False)

    def markdown(self) -> str:
        """Return the table with its title and notes."""
        lines = [f"# {self.title}", "", _row(self.columns), _row("---" for _ in self.columns)]
        lines += [_row(_shown(cell) for cell in row) for row in self.rows]
        lines += ["", *(f"- {note}" for note in self.notes)] if self.notes else []
        return "\n".join(lines) + "\n"

    def csv(self) -> str:
        """Return the table in full precision."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(["" if cell is None else cell for cell in row] for row in self.rows)
        return text.getvalue()

    def write(self, folder: Path) -> list[Path]:
        """Write `name.csv`, `name.md` and, if there is a figure, `name.png`; return their paths."""
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / f"{self.name}.csv", folder / f"{self.name}.md"]
        paths[0].write_text(self.csv())
        paths[1].write_text(self.markdown())
        if self.figure is not None:
            paths.append(folder / f"{self.name}.png")
            self.figure.savefig(paths[-1], dpi=150)
        return paths


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _shown(cell: Cell) -> str:
    if cell is None:
        return ""
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)
