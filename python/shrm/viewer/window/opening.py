"""What a file is that is dropped on the window or typed into it, and the state that shows it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from shrm.render.transferred import is_transfer
from shrm.viewer.window.state import State

MESHES = (".ply", ".obj", ".glb", ".gltf", ".stl", ".off")


def absolute(path: str) -> str:
    """Return a path that was typed as one that a saved window finds from any folder."""
    return str(Path(path).expanduser().absolute())


def with_file(state: State, path: str) -> State:
    """Return a state that shows a file: a mesh, an object with transfer, or else an environment.

    Meshes are known by their names, objects with transfer by their content too.
    """
    if Path(path).suffix.lower() in MESHES:
        return replace(state, mesh=path, transfer=None)
    if is_transfer(path):
        return replace(state, transfer=path)
    return replace(state, environment=path, layout=None, border=None)
