"""Pictures to files: tone-mapped PNG, or linear OpenEXR."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shrm.files import PathLike
from shrm.image_io import write_image
from shrm.render.picture import Picture
from shrm.render.tonemap import automatic_exposure, display


def write_picture(
    path: PathLike, picture: Picture, exposure: float | None = None, *, alpha: bool = False
) -> float | None:
    """Write a picture: .png through exposure and sRGB curve (`display`), other formats linear.

    Parameters
    ----------
    path : path
    picture : Picture
    exposure : float, optional
        In stops, for .png; by default `automatic_exposure` of the objects.
    alpha : bool
        Save the coverage as alpha, .png and .exr only; in .exr colors stay multiplied by it.

    Returns
    -------
    float or None
        The exposure used; None for linear formats.

    Raises
    ------
    shrm.image_io.ImageError
        If the file cannot be written.
    """
    coverage = picture.coverage if alpha else None
    if Path(path).suffix.lower() == ".png":
        stops = automatic_exposure(picture.radiance, picture.coverage) if exposure is None else exposure
        write_image(path, display(picture.radiance, stops, coverage))
        return stops
    channels = [picture.radiance] if coverage is None else [picture.radiance, coverage[..., None]]
    write_image(path, np.concatenate(channels, axis=2))
    return None
