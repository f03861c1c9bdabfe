"""Representations of reflected light held against direct integration: pictures of a sphere, random frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from shrm.arrays import FloatArray
from shrm.render import Picture, SupportsRadiance
from shrm.vectors import unit

from shrm_papers.errors import relative_rms
from shrm_papers.result import Cell
from shrm_papers.spheres import View, caption, difference, picture_error, show, sphere

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = ("representation", "center", "maps", "MB", "relative RMS error, picture", "the same, random frames")
"""Headings of `Judged.cells`."""


@dataclass(frozen=True, eq=False)
class Representation:
    """One way to store the reflected light of a material.

    Attributes
    ----------
    name : str
        Its name in the table.
    center : str
        The direction by which its maps are looked up.
    maps : int
        Number of its maps.
    nbytes : int
        Bytes of its maps as float32.
    reflection : SupportsRadiance
        The radiance that they give.
    """

    name: str
    center: str
    maps: int
    nbytes: int
    reflection: SupportsRadiance


@dataclass(frozen=True, eq=False)
class Judged:
    """A representation with its picture and its errors.

    Attributes
    ----------
    representation : Representation
        The representation.
    picture : Picture
        A sphere drawn from it.
    error, frames_error : float
        Relative RMS errors of the picture, and over random frames, colors pooled.
    """

    representation: Representation
    picture: Picture
    error: float
    frames_error: float

    @property
    def cells(self) -> list[Cell]:
        """The row of the table under `COLUMNS`."""
        form = self.representation
        return [form.name, form.center, form.maps, form.nbytes / 1e6, self.error, self.frames_error]


@dataclass(frozen=True, eq=False)
class Frames:
    """Random frames: N uniform over the sphere, cos^2(theta_v) uniform, T uniform across N.

    Attributes
    ----------
    normals, views, tangents : (n, 3) float64
        Unit vectors N, V, T.
    """

    normals: FloatArray
    views: FloatArray
    tangents: FloatArray

    @classmethod
    def drawn(cls, n: int, seed: int = 20020721) -> Frames:
        """Draw n frames."""
        rng = np.random.default_rng(seed)
        N = unit(rng.normal(size=(n, 3)))
        cosine = np.sqrt(rng.uniform(size=(n, 1)))
        V = cosine * N + np.sqrt(1 - cosine**2) * _across(N, rng)
        return cls(N, unit(V), _across(N, rng))

    def radiance(self, reflection: SupportsRadiance) -> FloatArray:
        """Return the radiance of a reflection in every frame, (n, 3)."""
        N, V, T = (np.ascontiguousarray(x, np.float32) for x in (self.normals, self.views, self.tangents))
        return reflection.radiance(N, V, tangents=T).astype(np.float64)


class Truth:
    """The reflected light by direct integration, which representations are judged by.

    Attributes
    ----------
    picture : Picture
        The sphere.
    """

    def __init__(self, exact: SupportsRadiance, view: View, pixels: int, frames: Frames):
        self.picture = sphere(exact, view, pixels)
        self._view, self._pixels, self._frames = view, pixels, frames
        self._radiance = frames.radiance(exact)

    def judge(self, representation: Representation) -> Judged:
        """Draw a representation and measure its errors."""
        reflection = representation.reflection
        picture = sphere(reflection, self._view, self._pixels)
        frames_error = relative_rms(self._frames.radiance(reflection), self._radiance)
        return Judged(representation, picture, picture_error(picture, self.picture), frames_error)


class Pictured(Protocol):
    """Anything with a picture."""

    @property
    def picture(self) -> Picture:
        """Linear radiance."""


class Compared(Pictured, Protocol):
    """Anything with a picture that was compared with the correct one."""

    @property
    def error(self) -> float:
        """Relative RMS of the picture, colors pooled."""


@dataclass(frozen=True)
class Block:
    """Two rows of a figure: the correct picture and others, and below these their differences from it.

    Attributes
    ----------
    name : str
        The material's name.
    truth : Pictured
        The correct picture.
    columns : sequence of (str, Compared)
        The others with their titles, of two lines each.
    correct : str
        The title of the correct picture.
    gain : float
        Factor that differences are shown with.
    """

    name: str
    truth: Pictured
    columns: Sequence[tuple[str, Compared]]
    correct: str = "correct"
    gain: float = 1.0


CELL, LABEL, TITLE, GAP = 1.75, 0.35, 0.5, 0.45
"""Inches: side of a picture, labels at the left, titles above, and space between blocks."""


def draw_blocks(blocks: Sequence[Block], beside: float = 0.0) -> Figure:
    """Draw blocks below one another, each with one exposure, that of its correct picture.

    Parameters
    ----------
    blocks : sequence of Block
        The blocks from top to bottom.
    beside : float
        Inches to leave free at the right.
    """
    from matplotlib.figure import Figure

    # The figure is as large as its cells of fixed size.
    columns = 1 + max(len(block.columns) for block in blocks)
    width = LABEL + CELL * columns + beside
    height = len(blocks) * (TITLE + 2 * CELL) + (len(blocks) - 1) * (GAP - TITLE) + 0.05
    figure = Figure(figsize=(width, height))
    exposures = [unclipped(block.truth.picture) for block in blocks]

    def place(picture: Picture, block: int, row: int, column: int) -> Axes:
        top = TITLE + block * (2 * CELL + GAP) + row * CELL
        corner = (LABEL + CELL * column) / width, (height - top - CELL) / height
        axes = figure.add_axes((*corner, CELL / width, CELL / height))
        gain = float(np.log2(blocks[block].gain)) if row == 1 else 0.0
        show(axes, picture, exposures[block] + gain)
        return axes

    # The correct picture, then each other one above its difference.
    for k, block in enumerate(blocks):
        axes = place(block.truth.picture, k, 0, 0)
        axes.set_title(block.correct, fontsize=9)
        axes.set_ylabel(block.name, fontsize=9)
        for column, (title, judged) in enumerate(block.columns, start=1):
            place(judged.picture, k, 0, column).set_title(title, fontsize=9)
            axes = place(difference(judged.picture, block.truth.picture), k, 1, column)
            caption(axes, f"{judged.error:.1%}")
            if column == 1:
                times = "" if block.gain == 1.0 else f" x {block.gain:g}"
                axes.set_ylabel(f"difference{times}", fontsize=9)
    return figure


def unclipped(picture: Picture) -> float:
    """Return the exposure in stops that shows the 98th percentile of the strongest colors as 1."""
    bright = np.percentile(picture.radiance[picture.coverage >= 0.5].max(axis=-1), 98.0)
    return -float(np.log2(bright)) if bright > 0 else 0.0


def _across(N: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return unit vectors across N, uniform around it."""
    return unit(np.cross(N, unit(rng.normal(size=N.shape))))
