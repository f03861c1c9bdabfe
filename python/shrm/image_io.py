"""Pictures in and out: the one module that knows OpenImageIO.

Reading gives linear Rec. 709 as (H, W, 3) float32, top row first, or an `ImageError` of one line that
names the file and the fault. What was changed on the way (alpha dropped, sRGB decoded, ...) is said
by an `ImageWarning`. Writing gives a whole file or none: it is written beside and then renamed.
"""

from __future__ import annotations

import os
import secrets
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio  # noqa: N813 - its own name for itself

from shrm import color

__all__ = [
    "DEFAULT_MAX_BYTES",
    "Image",
    "ImageError",
    "ImageWarning",
    "Part",
    "draw_text",
    "read_image",
    "read_parts",
    "write_image",
    "write_parts",
]

PathLike = str | os.PathLike[str]
Metadata = Mapping[str, str | int | float | Sequence[float]]
Pixels = npt.NDArray[np.float32]

DEFAULT_MAX_BYTES = 2 << 30

_CHANNEL_ORDER = "shrm:channels"  # EXR sorts channels by name; this attribute keeps our order


class ImageError(ValueError):
    """A picture cannot be read or written; the text names the file and the fault in one line."""


class ImageWarning(UserWarning):
    """A picture was changed while it was read or written, as the text says."""


@dataclass(frozen=True)
class Image:
    """A picture as read.

    Attributes
    ----------
    pixels : (H, W, 3) float32
        Linear Rec. 709, top row first.
    metadata : dict
        The file's attributes.
    layout : str or None
        ``"openexr-latlong"`` or ``"openexr-cube"`` where the file says so by OpenEXR's `envmap` attribute.
    """

    pixels: Pixels
    metadata: dict[str, Any] = field(default_factory=dict)
    layout: str | None = None


@dataclass(frozen=True)
class Part:
    """One named part of a multi-part EXR.

    Attributes
    ----------
    name : str
        Unique in its file.
    pixels : (H, W, C) float32
        Any quantity: nothing is converted.
    channels : sequence of C str
        Unique names.
    metadata : mapping
        Text, numbers, or sequences of floats.
    """

    name: str
    pixels: Pixels
    channels: Sequence[str]
    metadata: Metadata = field(default_factory=dict)


def read_image(path: PathLike, *, repair: bool = False, max_bytes: int = DEFAULT_MAX_BYTES) -> Image:
    """Read a picture as linear Rec. 709.

    Grey becomes RGB and alpha is dropped; integers (PNG, JPEG, ...) are decoded as sRGB unless the file
    says that it is linear; EXR `chromaticities` are converted; of a multi-part or mip-mapped file the
    first is taken. Negative values are kept. All but the last and the first are said by a warning.

    Parameters
    ----------
    path : path
    repair : bool
        Replace texels that are NaN or infinite by the mean of their neighbours, with a warning.
    max_bytes : int
        Refuse pictures that are larger than this when decoded; checked before pixels are read.

    Raises
    ------
    ImageError
        The file is missing, empty, no picture, truncated, too large, or has NaN or infinite texels.
    """
    source, spec = _open(path, max_bytes)
    try:
        columns, grey = _color_channels(path, spec)
        has_alpha = "A" in _short_names(spec)
        pixels = _read_pixels(path, source, spec, subimage=0)[:, :, columns]
        metadata = _metadata(spec)
        stored_as = str(spec.format)
        is_openexr = source.format_name() == "openexr"
    finally:
        source.close()
    if has_alpha:
        _warn(path, "its alpha channel is dropped")
    if grey:
        pixels = np.repeat(pixels, 3, axis=2)
    pixels = _orient(path, pixels, metadata)
    is_linear = (
        stored_as in ("half", "float", "double") or "lin" in str(metadata.get("oiio:ColorSpace", "")).lower()
    )
    if not is_linear:
        _warn(path, f"its {stored_as} values are decoded from sRGB to linear light")
        pixels = color.linear_from_srgb(pixels)
    pixels = _finite(path, np.ascontiguousarray(pixels, dtype=np.float32), repair)
    pixels = _to_rec709(path, pixels, metadata)
    negative = int(np.count_nonzero((pixels < 0).any(axis=2)))
    if negative:
        _warn(path, f"{negative} texels have negative values, the least {pixels.min():.4g}; they are kept")
    layouts = {"latlong environment": "openexr-latlong", "cubeface environment": "openexr-cube"}
    hint = layouts.get(str(metadata.get("textureformat", "")).lower())
    return Image(pixels, metadata, hint if is_openexr else None)


def read_parts(path: PathLike, *, max_bytes: int = DEFAULT_MAX_BYTES) -> list[Part]:
    """Read every part of an EXR as it is, without any conversion.

    Channels come back in the order in which `write_parts` was given them; those of other files in
    the file's order.

    Raises
    ------
    ImageError
        As `read_image`, but for NaN and infinite values, which are the caller's to judge.
    """
    source, spec = _open(path, max_bytes)
    parts: list[Part] = []
    try:
        left = max_bytes
        subimage = 0
        while True:
            left -= _decoded_bytes(spec)
            if left < 0:
                raise _too_large(path, spec, max_bytes)
            metadata = _metadata(spec)
            pixels = _read_pixels(path, source, spec, subimage)
            names = list(spec.channelnames)
            order = str(metadata.pop(_CHANNEL_ORDER, "")).split(",")
            if sorted(order) == sorted(names):
                pixels = np.ascontiguousarray(pixels[:, :, [names.index(name) for name in order]])
                names = order
            name = str(metadata.pop("oiio:subimagename", metadata.pop("name", "")))
            parts.append(Part(name, pixels, tuple(names), metadata))
            subimage += 1
            if not source.seek_subimage(subimage, 0):
                return parts
            spec = source.spec()
    finally:
        source.close()


def write_image(path: PathLike, pixels: npt.NDArray[Any], *, metadata: Metadata | None = None) -> None:
    """Write a picture; the format is the name's extension.

    Parameters
    ----------
    path : path
        ``.exr`` (float32), ``.hdr``, ``.pfm``, ``.tif`` (float32), or ``.png``, ``.jpg`` (8 bit).
    pixels : (H, W, 3) or, with alpha, (H, W, 4); float32, or uint8 for ``.png`` and ``.jpg``
        Linear Rec. 709, multiplied by alpha; the 8-bit formats take a picture that is tone-mapped and
        encoded already, not multiplied by alpha.
    metadata : mapping, optional
        Attributes to save where the format can (EXR).

    Raises
    ------
    ImageError
        The extension is unknown, the values do not fit the format, or the file cannot be written.
    TypeError, ValueError
        The array has another type or shape.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    eight_bit = suffix in (".png", ".jpg", ".jpeg")
    if not eight_bit and suffix not in (".exr", ".hdr", ".pfm", ".tif", ".tiff"):
        known = ".exr, .hdr, .pfm, .tif, .png, .jpg"
        raise ImageError(f"{path}: cannot write {suffix or 'a file without extension'}; use one of {known}")
    wanted: type[np.generic] = np.uint8 if eight_bit else np.float32
    if pixels.dtype != wanted:
        raise TypeError(f"pixels must be {wanted.__name__} for {suffix}, but are {pixels.dtype}")
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape:
        raise ValueError(f"pixels must have shape (H, W, 4) or (H, W, 3), but have {pixels.shape}")
    if not eight_bit:
        _finite(path, pixels, repair=False)
    if suffix == ".hdr" and np.any(pixels < 0):
        _warn(path, "the format has no negative values; they become 0")
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, oiio.UINT8 if eight_bit else oiio.FLOAT)
    if eight_bit:
        spec.attribute("oiio:UnassociatedAlpha", 1)
    if suffix == ".exr":
        spec.attribute("compression", "zip")
    spec.attribute("pnm:pfmflip", 1)  # a PFM's first row is the lowest; our first row is the highest
    _set_metadata(path, spec, metadata or {})
    _write(path, [spec], [pixels])


def write_parts(path: PathLike, parts: Sequence[Part]) -> None:
    """Write a multi-part float32 EXR with named channels, whole or not at all.

    Raises
    ------
    ImageError
        The file cannot be written, or is not named ``.exr``.
    TypeError, ValueError
        A part's array has another type or shape, or names are missing or repeated.
    """
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise ImageError(f"{path}: parts are saved as .exr only")
    if not parts or len({part.name for part in parts}) != len(parts):
        raise ValueError("parts must have unique names, and there must be at least one")
    specs = []
    for part in parts:
        if part.pixels.dtype != np.float32:
            raise TypeError(f"pixels of part {part.name!r} must be float32, but are {part.pixels.dtype}")
        if part.pixels.ndim != 3 or 0 in part.pixels.shape:
            raise ValueError(
                f"pixels of part {part.name!r} must have shape (H, W, C), not {part.pixels.shape}"
            )
        height, width, count = part.pixels.shape
        names = list(part.channels)
        if len(names) != count or len(set(names)) != count or any("," in n or not n for n in names):
            raise ValueError(
                f"part {part.name!r} needs {count} unique channel names without commas, not {names}"
            )
        spec = oiio.ImageSpec(width, height, count, oiio.FLOAT)
        spec.channelnames = tuple(names)
        spec.full_height = max(p.pixels.shape[0] for p in parts)  # EXR: one display window for all parts
        spec.full_width = max(p.pixels.shape[1] for p in parts)
        spec.attribute("oiio:subimagename", part.name)
        spec.attribute("compression", "zip")
        spec.attribute(_CHANNEL_ORDER, ",".join(names))
        _set_metadata(path, spec, part.metadata)
        specs.append(spec)
    _write(path, specs, [part.pixels for part in parts])


def draw_text(pixels: npt.NDArray[np.uint8], text: str, x: int, y: int, size: int) -> npt.NDArray[np.uint8]:
    """Return an 8-bit picture with a line of white text.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
    text : str
    x, y : int
        Where the text is centred from left to right, and its base line.
    size : int
        Height of the letters in pixels, about.
    """
    height, width, channels = pixels.shape
    picture = oiio.ImageBuf(oiio.ImageSpec(width, height, channels, oiio.UINT8))
    picture.set_pixels(picture.roi, np.ascontiguousarray(pixels))
    white = (1.0,) * channels
    oiio.ImageBufAlgo.render_text(picture, x, y, text, size, "DroidSans", white, "center", "baseline")
    return np.asarray(picture.get_pixels(oiio.UINT8)).reshape(pixels.shape)


# ---- reading, step by step


def _open(path: PathLike, max_bytes: int) -> tuple[Any, Any]:
    """Open a file and check its header."""
    path = Path(path)
    try:
        if path.is_dir():
            raise ImageError(f"{path}: is a folder, not a picture")
        if path.stat().st_size == 0:
            raise ImageError(f"{path}: is empty")
        with path.open("rb"):
            pass
    except OSError as error:
        raise ImageError(f"{path}: {error.strerror or error}") from None
    except ValueError as error:
        raise error if isinstance(error, ImageError) else ImageError(f"{path!r}: {error}") from None
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # colors as stored, not multiplied by alpha
    config.attribute("pnm:pfmflip", 1)  # a PFM's first row is the lowest; our first row is the highest
    source = _careful(lambda: oiio.ImageInput.open(str(path), config))
    if source is None:
        raise ImageError(f"{path}: is not a picture that can be read ({_fault(oiio.geterror)})")
    try:
        spec = source.spec()
        if spec.deep or spec.depth > 1:
            raise ImageError(f"{path}: is a deep or volume picture; a flat one is needed")
        if min(spec.width, spec.height, spec.nchannels) < 1:
            raise ImageError(f"{path}: has no pixels")
        if _decoded_bytes(spec) > max_bytes:
            raise _too_large(path, spec, max_bytes)
    except BaseException:
        source.close()
        raise
    return source, spec


def _careful(call: Callable[[], Any]) -> Any:
    """Call OpenImageIO, whose texts from damaged files may not be UTF-8; None where they are not."""
    try:
        return call()
    except UnicodeDecodeError:
        return None


def _fault(text: Callable[[], str]) -> str:
    """Return the first line of OpenImageIO's account of a failure."""
    lines = str(_careful(text) or "").strip().splitlines()
    return lines[0] if lines else "no further detail"


def _decoded_bytes(spec: Any) -> int:
    return int(spec.width) * int(spec.height) * int(spec.nchannels) * 4


def _too_large(path: PathLike, spec: Any, max_bytes: int) -> ImageError:
    size = f"{spec.width} x {spec.height} x {spec.nchannels} channels"
    need = (
        f"takes {_decoded_bytes(spec) / 2**20:.0f} MiB decoded, over the limit of {max_bytes / 2**20:.0f} MiB"
    )
    return ImageError(f"{path}: {size} {need}; raise max_bytes to read it")


def _short_names(spec: Any) -> list[str]:
    """Return the channels' names without those of layers, in capitals."""
    return [name.rsplit(".", 1)[-1].upper() for name in spec.channelnames]


def _color_channels(path: PathLike, spec: Any) -> tuple[list[int], bool]:
    """Return the channels that are red, green, blue, or the one that is grey; and whether it is grey."""
    names = _short_names(spec)
    if all(c in names for c in "RGB"):
        return [names.index(c) for c in "RGB"], False
    for name in ("Y", "L", "GRAY", "GREY"):
        if name in names:
            return [names.index(name)], True
    colors = [k for k, name in enumerate(names) if name != "A"]
    if len(colors) in (1, 3):
        return colors, len(colors) == 1
    raise ImageError(f"{path}: its channels {', '.join(spec.channelnames)} are neither RGB nor grey")


def _read_pixels(path: PathLike, source: Any, spec: Any, subimage: int) -> Pixels:
    pixels = _careful(lambda: source.read_image(subimage, 0, 0, spec.nchannels, oiio.FLOAT))
    if pixels is None or source.has_error:
        raise ImageError(f"{path}: is truncated or damaged ({_fault(source.geterror)})")
    result: Pixels = np.asarray(pixels, dtype=np.float32).reshape(spec.height, spec.width, spec.nchannels)
    return result


def _metadata(spec: Any) -> dict[str, Any]:
    """Return the attributes of a file; those whose text cannot be decoded are left out."""
    result: dict[str, Any] = {}
    for attribute in spec.extra_attribs:
        name = _careful(lambda a=attribute: a.name)  # type: ignore[misc]
        value = _careful(lambda a=attribute: a.value)  # type: ignore[misc]
        if name is not None and value is not None:
            result[name] = value
    return result


def _orient(path: PathLike, pixels: Pixels, metadata: Mapping[str, Any]) -> Pixels:
    """Turn a picture upright as its attribute Orientation (EXIF) says."""
    turns: dict[int, Callable[[Pixels], Pixels]] = {
        2: lambda p: p[:, ::-1],
        3: lambda p: p[::-1, ::-1],
        4: lambda p: p[::-1],
        5: lambda p: p.transpose(1, 0, 2),
        6: lambda p: np.rot90(p, -1),
        7: lambda p: np.rot90(p, 2).transpose(1, 0, 2),
        8: lambda p: np.rot90(p, 1),
    }
    orientation = metadata.get("Orientation", 1)
    if orientation not in turns:
        return pixels
    _warn(path, f"it is turned upright (orientation {orientation})")
    return turns[orientation](pixels)


def _to_rec709(path: PathLike, pixels: Pixels, metadata: Mapping[str, Any]) -> Pixels:
    chromaticities = metadata.get("chromaticities")
    if chromaticities is None or np.allclose(chromaticities, color.REC709, atol=2e-3):
        return pixels
    try:
        matrix = color.rec709_from_rgb(chromaticities)
    except ValueError as error:
        raise ImageError(f"{path}: {error}") from None
    _warn(path, "its chromaticities are converted to linear Rec. 709")
    return np.ascontiguousarray(pixels @ matrix.T.astype(np.float32))


def _finite(path: PathLike, pixels: Pixels, repair: bool) -> Pixels:
    """Refuse or repair texels that are NaN or infinite."""
    bad: npt.NDArray[np.bool_] = np.logical_not(np.isfinite(pixels).all(axis=2))
    count = int(np.count_nonzero(bad))
    if not count:
        return pixels
    row, column = np.argwhere(bad)[0]
    what = f"{count} texels are NaN or infinite, the first at row {row}, column {column}"
    if not repair:
        raise ImageError(f"{path}: {what}; repair=True replaces them by their neighbours")
    if count == bad.size:
        raise ImageError(f"{path}: all texels are NaN or infinite")
    pixels = np.where(bad[:, :, None], np.float32(0), pixels)
    while bad.any():  # from the rim of each hole inwards
        total = np.zeros(pixels.shape, dtype=np.float64)
        known = np.zeros(bad.shape, dtype=np.int64)
        padded = np.pad(pixels, ((1, 1), (1, 1), (0, 0)))
        valid = np.pad(~bad, 1)
        for i in range(3):
            for j in range(3):
                window = np.s_[i : i + bad.shape[0], j : j + bad.shape[1]]
                total += padded[window]
                known += valid[window]
        now = bad & (known > 0)
        pixels[now] = (total[now] / known[now, None]).astype(np.float32)
        bad &= ~now
    _warn(path, f"{what}; replaced by the mean of their neighbours")
    return pixels


def _warn(path: PathLike, what: str) -> None:
    warnings.warn(f"{os.fspath(path)}: {what}", ImageWarning, stacklevel=3)


# ---- writing


def _set_metadata(path: PathLike, spec: Any, metadata: Metadata) -> None:
    for name, value in metadata.items():
        if isinstance(value, (str, int, float)):
            spec.attribute(name, value)
            continue
        values = tuple(float(v) for v in value)
        if not values:
            raise ImageError(f"{path}: attribute {name!r} is an empty sequence")
        kind = oiio.TypeDesc(
            oiio.BASETYPE.FLOAT, oiio.AGGREGATE.SCALAR, oiio.VECSEMANTICS.NOSEMANTICS, len(values)
        )
        spec.attribute(name, kind, values)


def _write(path: Path, specs: Sequence[Any], pictures: Sequence[npt.NDArray[Any]]) -> None:
    """Write beside, then rename."""
    beside = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix.lower()}")
    output = oiio.ImageOutput.create(str(beside))
    if output is None:
        raise ImageError(f"{path}: cannot be written ({_fault(oiio.geterror)})")
    try:
        for part, (spec, pixels) in enumerate(zip(specs, pictures, strict=True)):
            if part:
                opened = output.open(str(beside), spec, "AppendSubimage")
            elif len(specs) > 1:
                opened = output.open(str(beside), tuple(specs))
            else:
                opened = output.open(str(beside), spec)
            if not opened or not output.write_image(np.ascontiguousarray(pixels)):
                raise ImageError(f"{path}: cannot be written ({_fault(output.geterror)})")
        if not output.close():
            raise ImageError(f"{path}: cannot be written ({_fault(output.geterror)})")
        os.replace(beside, path)
    except OSError as error:
        raise ImageError(f"{path}: cannot be written ({error.strerror or error})") from None
    finally:
        beside.unlink(missing_ok=True)
