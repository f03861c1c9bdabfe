"""A table or figure made again: rows of numbers, notes and a picture, and what they are made from."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from shrm.environment import Environment
from shrm.files import write_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = str | int | float | None


@dataclass(frozen=True)
class Settings:
    """The light, files and options that results are made with.

    Attributes
    ----------
    env : Environment
        The light.
    env_name : str
        The light's name in titles.
    fits : Path or None
        A folder with published fits to measured materials (`merl_abc_low2012.json`, ...), in place of those
        that come with the package.
    data : Path or None
        A folder with the folders `env`, `brdf` and `mesh`: photographed light, files of measured materials,
        meshes.
    mesh : Path or None
        A mesh to draw, y upwards.
    quick : bool
        True to take fewer rows and samples, only to see that everything runs.
    """

    env: Environment
    env_name: str
    fits: Path | None = None
    mesh: Path | None = None
    quick: bool = False
    data: Path | None = None


@dataclass(frozen=True)
class Result:
    """One table or figure made again.

    Attributes
    ----------
    name : str
        The stem of its files, such as "rh02-table-4".
    title : str
        Its subject in one line, without the number in the paper, which the name has.
    columns : sequence of str
        Headings; those of the paper's own numbers end in its key, such as "[RH02]".
    rows : sequence of sequences
        Cells, None where there is nothing to compare with.
    notes : sequence of str
        Differences from the paper with their reasons, and the meaning of the numbers, a sentence or two each.
    figure : matplotlib Figure or None
        The picture.
    summary : (columns, rows) or None
        A shorter table that stands before the full one in the Markdown; not in the CSV.
    """

    name: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()
    figure: Figure | None = field(default=None, compare=False)
    summary: tuple[Sequence[str], Sequence[Sequence[Cell]]] | None = None

    def markdown(self, level: int = 1) -> str:
        """Return the table with its title, picture and notes; the title is a heading of that level."""
        lines = [f"{'#' * level} {_heading(self.name)}: {self.title}", ""]
        if self.summary is not None:
            lines += [*_table(*self.summary), ""]
        lines += _table(self.columns, self.rows)
        lines += ["", f"![{self.title}]({self.name}.png)"] if self.figure is not None else []
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
        files = {"csv": self.csv().encode(), "md": self.markdown().encode()}
        if self.figure is not None:
            picture = io.BytesIO()
            self.figure.savefig(picture, format="png", dpi=150)
            files["png"] = picture.getvalue()
        for suffix, content in files.items():
            write_bytes(folder / f"{self.name}.{suffix}", content)
        return [folder / f"{self.name}.{suffix}" for suffix in files]


def _heading(name: str) -> str:
    """Return the name of a result as a heading has it: [RH02] table 4."""
    paper, *item = name.split("-")
    return " ".join([f"[{paper.upper()}]", *item])


def _table(columns: Sequence[str], rows: Sequence[Sequence[Cell]]) -> list[str]:
    """Return the lines of a Markdown table."""
    lines = [_row(columns), _row("---" for _ in columns)]
    return lines + [_row(_text(cell) for cell in row) for row in rows]


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _text(cell: Cell) -> str:
    """Return a cell to three digits, or to whole numbers above a thousand."""
    if cell is None:
        return ""
    if not isinstance(cell, float):
        return str(cell)
    return f"{cell:.0f}" if 1e3 <= abs(cell) < 1e7 else f"{cell:.3g}"
