"""The environment: light from every direction of a distant sphere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import shrm._core as _core
from shrm import image_io
from shrm.arrays import Float32Array, FloatArray, RealArray
from shrm.environment import daylight, layouts, paraboloid
from shrm.files import PathLike
from shrm.validation import (
    number,
    number_or_rgb,
    picture_shape,
    require_instance,
    rotation,
    unit_vectors,
    whole_number,
)

__all__ = ["Environment", "require_environment"]

# The names of a cube's faces in files, in the order +X -X +Y -Y +Z -Z of OpenGL.
_FACE_NAMES = (
    ("px", "nx", "py", "ny", "pz", "nz"),
    ("posx", "negx", "posy", "negy", "posz", "negz"),
    ("right", "left", "top", "bottom", "front", "back"),
    ("rt", "lf", "up", "dn", "ft", "bk"),
)


class Environment:
    """Radiance from every direction, as a lat-long picture.

    The center of the picture looks along +x, +y is a quarter of the width to the left, the top row is +z.

    Parameters
    ----------
    pixels : (H, W, 3) floating-point array
        Linear Rec. 709 radiance, finite, H >= 2 and W >= 4; W = 2 H is usual but not needed. Black and
        negative values are allowed. Kept as float32, a copy if the array can be written to.

    Raises
    ------
    TypeError
        pixels is not an array of floating-point numbers, or is a masked one.
    ValueError
        It has another shape, or texels that are NaN or infinite (in float32).

    Examples
    --------
    >>> env = Environment.daylight(sun_elevation=30.0)
    >>> env.pixels.shape
    (512, 1024, 3)
    """

    def __init__(self, pixels: RealArray) -> None:
        if not isinstance(pixels, np.ndarray) or not np.issubdtype(pixels.dtype, np.floating):
            kind = pixels.dtype if isinstance(pixels, np.ndarray) else type(pixels).__name__
            raise TypeError(f"pixels must be an array of floating-point numbers, got {kind}")
        if isinstance(pixels, np.ma.MaskedArray):
            raise TypeError("pixels must be a plain array, got a masked one: fill what is masked first")
        if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.shape[0] < 2 or pixels.shape[1] < 4:
            raise ValueError(
                f"pixels must have the shape (H, W, 3) with H >= 2 and W >= 4, got {pixels.shape}"
            )
        with np.errstate(over="ignore"):
            values = np.ascontiguousarray(pixels, dtype=np.float32)
        # A sum tells in a fraction of the time whether there is anything to look for.
        with np.errstate(over="ignore", invalid="ignore"):
            suspect = not np.isfinite(values.sum())
        if suspect and not np.isfinite(values).all():
            bad = ~np.isfinite(values).all(axis=2)
            row, column = np.argwhere(bad)[0]
            count = np.count_nonzero(bad)
            raise ValueError(
                f"pixels must be finite, got {count} texels that are not, the first at row {row}, "
                f"column {column}"
            )
        # The coefficients are kept: what they were taken from must not change.
        if pixels.flags.writeable and np.may_share_memory(values, pixels):
            values = values.copy()
        self._pixels = values.view()
        self._pixels.flags.writeable = False
        self._coefficients: FloatArray | None = None

    @property
    def pixels(self) -> Float32Array:
        """The (H, W, 3) float32 lat-long picture, read-only."""
        return self._pixels

    def __repr__(self) -> str:
        H, W, _ = self._pixels.shape
        mean = layouts.solid_angles("latlong", H, 1)[:, 0] @ self._pixels.mean(axis=1, dtype=np.float64)
        red, green, blue = mean / (4 * math.pi)
        return f"<Environment {H} x {W}, mean radiance {red:.3g}, {green:.3g}, {blue:.3g}>"

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """Return the pixels, as `np.asarray(env)` does: read-only unless they are copied."""
        return np.array(self._pixels, dtype=dtype, copy=copy)

    @classmethod
    def read(
        cls,
        path: PathLike,
        layout: str | None = None,
        *,
        repair: bool = False,
        max_bytes: int = image_io.DEFAULT_MAX_BYTES,
        border: int | None = None,
    ) -> Environment:
        """Read an environment in any layout and convert it, area-exactly, to a lat-long picture.

        Parameters
        ----------
        path : path
            A picture; for six faces, a folder of them or a pattern with ``{}`` for the face's name
            (px nx py ny pz nz, posx ..., right left top bottom front back, rt lf up dn ft bk).
        layout : str, optional
            One of `shrm.environment.layouts.LAYOUTS`; by default what the file states (what `write` wrote
            into it, or OpenEXR's `envmap` attribute) or its aspect suggests, see
            `shrm.environment.layouts.recognise`.
        repair : bool
            Replace NaN and infinite texels by their neighbors instead of refusing them.
        max_bytes : int
            The largest decoded picture that is read.
        border : int, optional
            Texels round each face of a dual paraboloid, for that layout alone; by default what the file
            states, or none.

        Raises
        ------
        ImageError
            A ValueError of one line that names the file and what is wrong with it. What is merely changed
            is said by an `ImageWarning`.
        ValueError
            layout is not a known name.
        """
        if layout is not None:
            layout = layouts.check(layout)
        if border is not None:
            whole_number("border", border, 0, 8192)
        try:
            if layout == "faces" or Path(path).is_dir() or (layout is None and "{}" in str(path)):
                pixels, layout = _read_faces(Path(path), repair, max_bytes), "faces"
            else:
                image = image_io.read_image(path, repair=repair, max_bytes=max_bytes)
                pixels = image.pixels
                if min(pixels.shape[:2]) < 2:
                    size = f"{pixels.shape[1]} x {pixels.shape[0]}"
                    raise image_io.ImageError(
                        f"{path}: a picture of {size} is too small to be an environment"
                    )
                if border is None and layout in (None, image.layout):
                    border = image.border
                layout = layout or layouts.recognise(pixels.shape[0], pixels.shape[1], image.layout)
            if border:
                _require_border(border, layout)
                pixels = paraboloid.without_border(pixels, border)
            height, width = pixels.shape[:2]
            if layout == "latlong":
                return cls(_read_only(pixels))
            rows = layouts.size_like("latlong", layout, height, width)
            return cls(_read_only(layouts.convert(pixels, layout, "latlong", rows)))
        except image_io.ImageError:
            raise
        except ValueError as error:
            raise image_io.ImageError(f"{path}: {error}") from None

    def write(
        self, path: PathLike, layout: str = "latlong", size: int | None = None, *, border: int = 0
    ) -> None:
        """Write the environment as a picture in any layout.

        Parameters
        ----------
        path : path
            ``.exr`` (float32), ``.hdr`` (0.4% per value), ``.pfm`` or ``.tif``. For ``faces``, ``{}``
            stands for px nx py ny pz nz; without it they follow the name (``sky.exr``: ``sky_px.exr``, ...).
        layout : str
            One of `shrm.environment.layouts.LAYOUTS`.
        size, border : int, optional
            See `picture`.

        Raises
        ------
        ImageError
            The file cannot be written.
        TypeError, ValueError
            layout is not a known name, or size is below 2.
        """
        path, layout = Path(path), layouts.check(layout)
        picture = self.picture(layout, size, border=border)
        if layout == "faces":
            pattern = (
                str(path) if "{}" in path.name else str(path.with_name(f"{path.stem}_{{}}{path.suffix}"))
            )
            for name, face in zip(_FACE_NAMES[0], picture, strict=True):
                image_io.write_image(pattern.replace("{}", name), np.ascontiguousarray(face))
            return
        image_io.write_image(path, picture, metadata=image_io.layout_metadata(path.suffix, layout, border))

    def picture(self, layout: str, size: int | None = None, *, border: int = 0) -> Float32Array:
        """Return the environment in another layout, converted area-exactly.

        Parameters
        ----------
        layout : str
            One of `shrm.environment.layouts.LAYOUTS`.
        size : int, optional
            Rows of a lat-long picture, or the edge of a cube's face, of a disc, or of the octahedron's
            square; by default what keeps the detail.
        border : int
            Texels round each face of a dual paraboloid, for that layout alone, which continue it beyond the
            disc; they are not counted in the size.

        Returns
        -------
        (H', W', 3) float32; (6, n, n, 3) for ``faces``
            0 where the layout is empty.

        Raises
        ------
        TypeError, ValueError
            layout is not a known name, or size is below 2.
        """
        layout = layouts.check(layout)
        height, width = self._pixels.shape[:2]
        if size is None:
            size = layouts.size_like(layout, "latlong", height, width)
            shape = (height, width) if layout == "latlong" else layouts.shape(layout, size)
        else:
            shape = layouts.shape(layout, size)
        _require_border(border, layout)
        result = layouts.convert(self._pixels, "latlong", layout, shape)
        if border:
            return paraboloid.bordered(self._pixels, result, border)
        return result.reshape(6, shape[1], shape[1], 3) if layout == "faces" else result

    def rotated(self, R: npt.ArrayLike) -> Environment:
        """Return the environment turned by R: L'(w) = L(R^T w), area-exactly.

        Parameters
        ----------
        R : (3, 3) array
            A rotation: R^T R = 1 and det R = 1, to 1e-6.

        Raises
        ------
        TypeError, ValueError
            R is not a rotation.
        """
        turn = rotation("R", R)
        shape = (self._pixels.shape[0], self._pixels.shape[1])
        return Environment(_read_only(layouts.convert(self._pixels, "latlong", "latlong", shape, turn)))

    def resized(self, shape: tuple[int, int]) -> Environment:
        """Return the environment as H x W texels, area-exactly.

        Parameters
        ----------
        shape : (H, W)
            Rows and columns, at least 2 and 4, at most 65536.

        Returns
        -------
        Environment

        Raises
        ------
        TypeError, ValueError
            If shape is not that.
        """
        of_texels = picture_shape("shape", shape, least=(2, 4))
        return Environment(_read_only(layouts.convert(self._pixels, "latlong", "latlong", of_texels)))

    def coefficients(self, F: int) -> FloatArray:
        """Return the spherical harmonic coefficients of the radiance, texels taken as areas.

        Parameters
        ----------
        F : int
            The largest degree, 0 to 1000.

        Returns
        -------
        ((F+1)^2, 3) float64
            In the real basis at index l (l + 1) + m; L_lm of [RH02] section 6.1.

        Raises
        ------
        TypeError, ValueError
            F is no such number, or the radiance is so large that its integrals overflow.
        """
        count = (whole_number("F", F, 0, 1000) + 1) ** 2
        if self._coefficients is None or len(self._coefficients) < count:
            coefficients = _core.analysis(pixels=self._pixels, F=int(F), areas=True)
            if not np.isfinite(coefficients).all():
                largest = np.abs(self._pixels).max()
                raise ValueError(f"pixels must have integrals that do not overflow, got up to {largest:.3g}")
            self._coefficients = coefficients
        result: FloatArray = self._coefficients[:count].copy()
        return result

    def irradiance(self, normals: npt.ArrayLike) -> Float32Array:
        """Return the irradiance by the nine-term formula, accurate to a few per cent [RH01].

        Parameters
        ----------
        normals : (n, 3) array
            Unit vectors, to 1e-4.

        Returns
        -------
        (n, 3) float32
            E(N) = sum over l <= 2 of A_l L_lm Y_lm(N) [RH01, eq. 8]; a diffuse surface reflects
            albedo / pi of it.

        Raises
        ------
        TypeError, ValueError
            normals has another shape, or is not of unit vectors.
        """
        n = unit_vectors("normals", normals)
        A = np.array([math.pi] + 3 * [2 * math.pi / 3] + 5 * [math.pi / 4])  # [RH01] eq. 9
        result: Float32Array = ((_basis(n) * A) @ self.coefficients(2)).astype(np.float32)
        return result

    @classmethod
    def daylight(
        cls,
        *,
        sun_elevation: float = 35.0,
        sun_azimuth: float = 50.0,
        turbidity: float = 2.5,
        albedo: float | Sequence[float] = (0.24, 0.21, 0.17),
        size: int = 512,
    ) -> Environment:
        """Return a clear sky with its sun over a plain ground; `shrm.environment.daylight` has the formulas.

        Radiance 1 is 20 kcd/m^2: a white diffuse surface in the sun is about 1, and needs no exposure.

        Parameters
        ----------
        sun_elevation : float
            Degrees above the horizon, 0 to 90.
        sun_azimuth : float
            Degrees from +x towards +y.
        turbidity : float
            Haze, 1.8 to 10: 2 is very clear.
        albedo : float or 3 floats
            Albedo of the ground, 0 to 1.
        size : int
            Rows of the picture, even, >= 2; it is twice as wide.

        Raises
        ------
        TypeError, ValueError
            A parameter is out of its range.
        """
        number("sun_elevation", sun_elevation, 0.0, 90.0)
        number("sun_azimuth", sun_azimuth)
        number("turbidity", turbidity, 1.8, 10.0)
        ground = np.broadcast_to(number_or_rgb("albedo", albedo, 0.0, 1.0), 3)
        if whole_number("size", size, 2) % 2:
            raise ValueError(f"size must be even, got {size}")
        return cls(daylight.daylight_pixels(sun_elevation, sun_azimuth, turbidity, ground, size))


def require_environment(value: object, name: str = "env") -> None:
    """Refuse what is no Environment.

    Raises
    ------
    TypeError
        If it is none; the text names the argument.
    """
    require_instance(name, value, Environment)


def _read_only(pixels: Float32Array) -> Float32Array:
    """Give up writing to an array of one's own, so that it is kept without a copy."""
    pixels.flags.writeable = False
    return pixels


def _basis(n: FloatArray) -> FloatArray:
    """Return the nine real harmonics with the Condon-Shortley phase, (n, 9), as polynomials [RH01, eq. 3]."""
    x, y, z = n.T
    degree_1, degree_2 = math.sqrt(3 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi))
    return np.stack(
        [
            np.full_like(x, math.sqrt(1 / (4 * math.pi))),
            -degree_1 * y,
            degree_1 * z,
            -degree_1 * x,
            degree_2 * x * y,
            -degree_2 * y * z,
            math.sqrt(5 / (16 * math.pi)) * (3 * z * z - 1),
            -degree_2 * x * z,
            degree_2 / 2 * (x * x - y * y),
        ],
        axis=1,
    )


def _require_border(border: int, layout: str | None) -> None:
    if whole_number("border", border, 0, 8192) and layout != "dual-paraboloid":
        raise ValueError(f"border is for the layout dual-paraboloid, got {layout}")


def _read_faces(path: Path, repair: bool, max_bytes: int) -> Float32Array:
    """Read six faces and stack them as a strip, (6n, n, 3)."""
    faces = [
        image_io.read_image(p, repair=repair, max_bytes=max_bytes // 6).pixels for p in _find_faces(path)
    ]
    shapes = {face.shape for face in faces}
    if len(shapes) != 1 or faces[0].shape[0] != faces[0].shape[1]:
        sizes = ", ".join(f"{face.shape[1]} x {face.shape[0]}" for face in faces)
        raise image_io.ImageError(f"{path}: the six faces must be squares of one size, got {sizes}")
    return np.concatenate(faces)


def _find_faces(path: Path) -> list[Path]:
    """Return the six files of a folder or a pattern, in OpenGL's order."""
    for names in _FACE_NAMES:
        if "{}" in str(path):
            files = [Path(str(path).replace("{}", name)) for name in names]
            if all(file.is_file() for file in files):
                return files
        elif path.is_dir():
            matches = [
                [f for f in sorted(path.iterdir()) if _ends_with(f.stem.lower(), name)] for name in names
            ]
            if all(len(f) == 1 for f in matches):
                return [f[0] for f in matches]
    schemes = "; ".join(" ".join(names) for names in _FACE_NAMES)
    raise image_io.ImageError(f"{path}: no six faces found there, named by one of the schemes {schemes}")


def _ends_with(stem: str, name: str) -> bool:
    """Tell whether a file's name ends in a face's name as a word of its own."""
    return stem == name or (stem.endswith(name) and not stem[-len(name) - 1].isalpha())
