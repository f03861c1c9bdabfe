"""Screenshots: numbered files of what is shown."""

from __future__ import annotations

from pathlib import Path

from shrm.render.output import write_picture
from shrm.render.picture import Picture

SUFFIXES = (".png", ".exr")


def save_screenshot(folder: Path, picture: Picture, exposure: float, alpha: bool) -> Path:
    """Write the next of shrm-001.png, shrm-002.png ... as shown, and beside it an .exr, linear.

    Parameters
    ----------
    folder : Path
    picture : Picture
    exposure : float
        Stops, for the PNG.
    alpha : bool
        Whether the coverage is written.

    Returns
    -------
    Path
        The PNG's.

    Raises
    ------
    OSError, shrm.ImageError
        If a file cannot be written.
    """
    number = 1
    while any((folder / f"shrm-{number:03d}{suffix}").exists() for suffix in SUFFIXES):
        number += 1
    png = folder / f"shrm-{number:03d}.png"
    write_picture(png, picture, exposure, alpha=alpha)
    write_picture(png.with_suffix(".exr"), picture, alpha=alpha)
    return png
