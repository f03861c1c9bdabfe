"""Folders of the visibility of a small mesh."""

from pathlib import Path

from shrm.transfer.rays.directions import local_directions
from shrm.transfer.rays.visibility import Visibility
from shrm.transfer.tangent_frames import vertex_frames

from support.transfer_meshes import bumpy

VERTICES, FACES, NORMALS = bumpy(6)  # 162 vertices: blocks of 50, 50, 50 and 12
GOOD = {
    "vertices": VERTICES,
    "faces": FACES,
    "frames": vertex_frames(NORMALS),
    "directions": local_directions(64),
    "hits": True,
    "block": 50,
}


def opened(folder: Path, **change: object) -> Visibility:
    return Visibility(folder, **{**GOOD, **change})


def computed(folder: Path) -> Visibility:
    visibility = opened(folder)
    visibility.compute()
    return visibility
