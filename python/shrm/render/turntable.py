"""Turntables: the light or the camera goes once round the vertical, a picture for each step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from shrm.render.camera import Camera
from shrm.render.placement import about_vertical


def turned_camera(camera: Camera, degrees: float) -> Camera:
    """Return the camera carried round its target by an angle."""
    target = np.asarray(camera.target, np.float64)
    x, y, z = target + about_vertical(degrees) @ (np.asarray(camera.position, np.float64) - target)
    return replace(camera, position=(float(x), float(y), float(z)))


def numbered(path: Path, frame: int, frames: int) -> Path:
    """Return the name of a frame, such as spin-007.png: as many digits as the last one needs."""
    digits = max(3, len(str(frames - 1)))
    return path.with_name(f"{path.stem}-{frame:0{digits}d}{path.suffix}")
