"""Layouts: the ways to lay the sphere of directions out as a picture, and to go from one to another.

``latlong``
    (n, 2n), the project's own; ``openexr-latlong`` has its axes, but texel centers on the edges.
``vertical-cross``, ``horizontal-cross``
    (4n, 3n) and (3n, 4n): a cube unfolded round its front (the center of the lat-long picture).
``strip``
    (n, 6n) or (6n, n): the faces +X -X +Y -Y +Z -Z of an OpenGL cube map; +Z is front, +X right, +Y up.
    It may be called ``cube`` too, as the maps of reflections are.
``faces``
    The same in six files; as an array the strip (6n, n).
``openexr-cube``
    (6n, n): OpenEXR's cube, texel centers on the edges.
``angular``, ``mirror-ball``
    (n, n): Debevec's light probe, its center looking to the front; the same with the radii of a mirrored
    ball. (Flip the photograph of a real ball left to right: it shows the world mirrored.)
``dual-paraboloid``
    (n, 2n): the half above and the half below.
``octahedral``
    (n, n): its center looks up.

Each layout's axes stand in ``cpp/shrm/pictures/layouts.hpp``, where they are implemented.
"""

from __future__ import annotations

import math

import numpy as np

import shrm._core as _core
from shrm.arrays import Float32Array, FloatArray
from shrm.validation import one_of, whole_number

__all__ = [
    "LAYOUTS",
    "check",
    "convert",
    "directions",
    "positions",
    "rays",
    "recognise",
    "shape",
    "size_like",
    "solid_angles",
]

LAYOUTS = (
    "latlong",
    "openexr-latlong",
    "vertical-cross",
    "horizontal-cross",
    "strip",
    "faces",
    "openexr-cube",
    "angular",
    "mirror-ball",
    "dual-paraboloid",
    "octahedral",
)

_CUBES = ("vertical-cross", "horizontal-cross", "strip", "faces", "openexr-cube")


def check(layout: str) -> str:
    """Return the name of a layout as `LAYOUTS` has it, or raise a ValueError that lists them."""
    return one_of("layout", "strip" if layout == "cube" else layout, LAYOUTS)


def _core_name(layout: str) -> str:
    """Return the name by which the core knows a layout: six faces are a strip."""
    name = check(layout)
    return "strip" if name == "faces" else name


def recognise(height: int, width: int, hint: str | None = None) -> str:
    """Return the layout of a picture from its aspect, or from what its file says.

    2:1 is ``latlong``, 1:1 ``angular``, 3:4 ``vertical-cross``, 4:3 ``horizontal-cross``, 6:1 and 1:6
    ``strip`` (width : height). The layouts that share an aspect with one of these must be named.

    Raises
    ------
    ValueError
        No layout has this aspect; the text lists the layouts.
    """
    if hint is not None:
        return check(hint)
    if width == height:
        return "angular"
    if width == 2 * height:
        return "latlong"
    if width % 3 == 0 and 4 * width == 3 * height:
        return "vertical-cross"
    if height % 3 == 0 and 4 * height == 3 * width:
        return "horizontal-cross"
    if 6 in (width / height, height / width):
        return "strip"
    raise ValueError(
        f"a picture must have a layout's aspect, got {width} x {height}; name one of {', '.join(LAYOUTS)}"
    )


def shape(layout: str, size: int) -> tuple[int, int]:
    """Return the (height, width) of a picture in a layout.

    Parameters
    ----------
    layout : str
    size : int
        Rows of a lat-long picture, or the edge n of a cube's face, of a disc, or of the octahedron's square;
        at least 2.

    Raises
    ------
    TypeError, ValueError
        An unknown layout, or a size below 2.
    """
    layout = check(layout)
    size = whole_number("size", size, 2)
    shapes = {
        "latlong": (size, 2 * size),
        "openexr-latlong": (size, 2 * size),
        "vertical-cross": (4 * size, 3 * size),
        "horizontal-cross": (3 * size, 4 * size),
        "strip": (size, 6 * size),
        "faces": (6 * size, size),
        "openexr-cube": (6 * size, size),
        "dual-paraboloid": (size, 2 * size),
    }
    return shapes.get(layout, (size, size))


def size_like(layout: str, like: str, height: int, width: int) -> int:
    """Return the size for a layout that keeps the detail of a picture of height x width in another.

    A cube's face of n texels is worth 2n rows of latitude and longitude; other layouts are compared with a
    cube of as many texels.
    """
    layout, like = check(layout), check(like)
    texels_per_square = {"octahedral": 1.0, "dual-paraboloid": math.pi / 2}

    def face_per_size(name: str) -> float:
        if name in _CUBES:
            return 1.0
        if name in ("latlong", "openexr-latlong"):
            return 0.5
        return math.sqrt(texels_per_square.get(name, math.pi / 4) / 6)

    edge = {"vertical-cross": height // 4, "horizontal-cross": height // 3, "strip": min(height, width)}
    size = edge.get(like, width if like in ("faces", "openexr-cube") else height)
    return max(2, math.ceil(size * face_per_size(like) / face_per_size(layout) - 1e-9))


def rays(layout: str, height: int, width: int, positions: FloatArray) -> FloatArray:
    """Return where (n, 2) positions look: (n, 3) unit vectors, NaN outside the layout.

    A position is x to the right and y down, in texels: texel (i, j) is [j, j + 1] x [i, i + 1].
    """
    result: FloatArray
    result, density = _core.rays(
        layout=_core_name(layout), height=height, width=width, positions=np.ascontiguousarray(positions)
    )
    result[density < 0] = np.nan
    return result


def directions(layout: str, height: int, width: int) -> FloatArray:
    """Return where texel centers look: (height, width, 3) unit vectors, NaN outside the layout."""
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    centers = np.stack([x.ravel(), y.ravel()], axis=1)
    return rays(layout, height, width, centers).reshape(height, width, 3)


def positions(layout: str, height: int, width: int, directions: FloatArray) -> FloatArray:
    """Return where (n, 3) unit directions fall in a picture: (n, 2) positions, the inverse of `rays`."""
    result: FloatArray = _core.positions(
        layout=_core_name(layout), height=height, width=width, directions=np.ascontiguousarray(directions)
    )
    return result


def solid_angles(layout: str, height: int, width: int) -> FloatArray:
    """Return the exact solid angles of the texels, (height, width) in steradians; their sum is 4 pi.

    Texels that the edge of a layout cuts count for their part, those outside for 0.
    """
    result: FloatArray = _core.solid_angles(layout=_core_name(layout), height=height, width=width)
    return result


def convert(
    pixels: Float32Array,
    source: str,
    target: str,
    size: int | tuple[int, int],
    rotation: FloatArray | None = None,
) -> Float32Array:
    """Convert a picture of the sphere area-exactly: light is moved, not sampled.

    The integral over the sphere is kept, and so is the light of every single texel, to 1e-3 or better; a
    constant stays constant. Every texel is taken as an area of one radiance, so that enlarging shows texels
    as they are.

    Parameters
    ----------
    pixels : (H, W, C) float32
        The picture.
    source, target : str
        Its layout, and that of the result.
    size : int or (height, width)
        Size of the result, as in `shape`, or its height and width.
    rotation : (3, 3) float64, optional
        A proper rotation R: radiance from direction w is then found in direction R w.

    Returns
    -------
    (H', W', C) float32
        0 outside the layout.

    Raises
    ------
    ValueError
        An unknown layout, or a size that it cannot have.
    """
    height, width = shape(target, size) if isinstance(size, int) else size
    names = _core_name(source), _core_name(target)
    if names[0] == names[1] and rotation is None and pixels.shape[:2] == (height, width):
        return np.where(solid_angles(target, height, width)[:, :, None] > 0, pixels, np.float32(0))
    turn = np.eye(3) if rotation is None else np.ascontiguousarray(rotation, dtype=np.float64)
    result: Float32Array
    result, _ = _core.convert(
        pixels=np.ascontiguousarray(pixels),
        source=names[0],
        target=names[1],
        height=height,
        width=width,
        rotation=turn,
    )
    return result
