"""Ways to store reflected light, held against direct integration: pictures of a sphere, and random frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from shrm.arrays import FloatArray
from shrm.render import Picture, Reflection

from shrm_papers.result import Cell
from shrm_papers.spheres import View, caption, difference, relative_rms, show, sphere

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
    center : str
        The direction that its maps are looked up by.
    maps : int
        Pictures of the sphere that it takes.
    nbytes : int
        What they take as float32.
    reflection : Reflection
        What gives the radiance.
    """

    name: str
    center: str
    maps: int
    nbytes: int
    reflection: Reflection


@dataclass(frozen=True, eq=False)
class Judged:
    """A representation, its picture, and its relative RMS errors, colors pooled."""

    representation: Representation
    picture: Picture
    error: float
    frames_error: float

    @property
    def cells(self) -> list[Cell]:
        """A row of the table, under `COLUMNS`."""
        this = self.representation
        return [this.name, this.center, this.maps, this.nbytes / 1e6, self.error, self.frames_error]


@dataclass(frozen=True, eq=False)
class Frames:
    """Random frames: N uniform, cos^2 of the view's angle to N uniform, T anywhere across N.

    Attributes
    ----------
    normals, views, tangents : (n, 3) float64
        Unit vectors.
    """

    normals: FloatArray
    views: FloatArray
    tangents: FloatArray

    @classmethod
    def drawn(cls, n: int, seed: int = 20020721) -> Frames:
        """Draw n of them."""
        rng = np.random.default_rng(seed)
        N = _unit(rng.normal(size=(n, 3)))
        cosine = np.sqrt(rng.uniform(size=(n, 1)))
        V = cosine * N + np.sqrt(1 - cosine**2) * _across(N, rng)
        return cls(N, _unit(V), _across(N, rng))

    def radiance(self, reflection: Reflection) -> FloatArray:
        """Return what a reflection gives for all of them, (n, 3)."""
        N, V, T = (np.ascontiguousarray(x, np.float32) for x in (self.normals, self.views, self.tangents))
        return reflection.radiance(N, V, tangents=T).astype(np.float64)


class Truth:
    """The reflected light by direct integration.

    Attributes
    ----------
    picture : Picture
        Of a sphere.
    """

    def __init__(self, exact: Reflection, view: View, pixels: int, frames: Frames):
        self.picture = sphere(exact, view, pixels)
        self._view, self._pixels, self._frames = view, pixels, frames
        self._radiance = frames.radiance(exact)

    def judge(self, this: Representation) -> Judged:
        """Draw a representation and measure its errors."""
        picture = sphere(this.reflection, self._view, self._pixels)
        missed = self._frames.radiance(this.reflection) - self._radiance
        frames_error = float(np.sqrt(np.sum(missed**2) / np.sum(self._radiance**2)))
        return Judged(this, picture, relative_rms(picture, self.picture), frames_error)


class Pictured(Protocol):
    """What there is a picture of."""

    @property
    def picture(self) -> Picture:
        """Linear."""


class Compared(Pictured, Protocol):
    """What a picture is held against another for."""

    @property
    def error(self) -> float:
        """Relative RMS, colors pooled."""


@dataclass(frozen=True)
class Block:
    """Two lines of a figure: the correct picture and others, and below them what they are off by.

    Attributes
    ----------
    name : str
        Of the material.
    truth : Pictured
    columns : sequence of (str, Compared)
        Titles, of two lines, and what stands below them.
    correct : str
        The title of the correct picture.
    gain : float
        What differences are multiplied by.
    """

    name: str
    truth: Pictured
    columns: Sequence[tuple[str, Compared]]
    correct: str = "correct"
    gain: float = 1.0


CELL, LABEL, TITLE, GAP = 1.75, 0.35, 0.5, 0.45  # inches


def draw_blocks(blocks: Sequence[Block], beside: float = 0.0) -> Figure:
    """Draw blocks below each other; each has one exposure, from its correct picture.

    Parameters
    ----------
    blocks : sequence of Block
    beside : float
        Inches to leave free at the right.
    """
    from matplotlib.figure import Figure

    columns = 1 + max(len(block.columns) for block in blocks)
    width = LABEL + CELL * columns + beside
    height = len(blocks) * (TITLE + 2 * CELL) + (len(blocks) - 1) * (GAP - TITLE) + 0.05
    figure = Figure(figsize=(width, height))
    exposures = [unclipped(block.truth.picture) for block in blocks]

    def place(picture: Picture, block: int, line: int, column: int) -> Axes:
        top = TITLE + block * (2 * CELL + GAP) + line * CELL
        corner = (LABEL + CELL * column) / width, (height - top - CELL) / height
        axes = figure.add_axes((*corner, CELL / width, CELL / height))
        gain = float(np.log2(blocks[block].gain)) if line == 1 else 0.0
        show(axes, picture, exposures[block] + gain)
        return axes

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
    """Stops that put the 98th percentile of what is covered, in its strongest color, at its limit."""
    bright = np.percentile(picture.radiance[picture.coverage >= 0.5].max(axis=-1), 98.0)
    return -float(np.log2(bright)) if bright > 0 else 0.0


def _across(N: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Unit vectors across N, uniform around it."""
    return _unit(np.cross(N, _unit(rng.normal(size=N.shape))))


def _unit(x: FloatArray) -> FloatArray:
    return np.asarray(x / np.linalg.norm(x, axis=-1, keepdims=True))
