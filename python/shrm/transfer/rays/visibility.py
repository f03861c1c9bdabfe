"""What every vertex of a mesh sees, in a folder: computed block by block, and continued after a stop.

    visibility.json         what it was computed from, and the size of every block that is finished
    visibility_00000.npz    the first block of vertices, and so on. Arrays of numpy's format:
        visible (B, D/8) uint8    a bit for each direction, the first the highest; 1: the ray meets nothing
        face    (H,) int32        with hits: of every ray that is blocked, row by row, the face it meets, -1
                                  if from behind
        u, v    (H,) uint16       the place on the face, in units of 1/65535

A file is written beside its place, then renamed; a block counts from when visibility.json says so. So a
process may end at any moment: what it had finished stays, and the rest is computed again.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import BoolArray, FloatArray, Int32Array
from shrm.files import PathLike, write_bytes
from shrm.transfer.described import Described
from shrm.transfer.rays.occluders import Hits, Occluders
from shrm.validation import whole_number

VERSION = 1
"""The version of such folders; those of another are refused."""

_STATE = "visibility.json"
"""The file that says what is there."""

_PLACES = 65535
"""Steps of u and v: the largest uint16."""


@dataclass(frozen=True, eq=False, repr=False)
class Block(Described):
    """Block of vertices that follow each other, and what their rays meet.

    Attributes
    ----------
    first : int
        The first vertex.
    visible : (B, D) bool
        Where the rays of B vertices meet nothing.
    hits : Hits or None
        Where the others end, if that was computed.
    """

    first: int
    visible: BoolArray
    hits: Hits | None

    @property
    def vertices(self) -> slice:
        """The vertices that these are."""
        return slice(self.first, self.first + len(self.visible))

    def parts(self, size: int) -> Iterator[Block]:
        """Yield the block in parts of `size` vertices; the last may have fewer."""
        counts = self.visible.shape[1] - np.count_nonzero(self.visible, axis=1)
        ends = np.concatenate([[0], np.cumsum(counts)])
        for a in range(0, len(self.visible), size):
            visible, hits = self.visible[a : a + size], None
            if self.hits is not None:
                these = slice(ends[a], ends[a + len(visible)])
                hits = Hits(self.hits.face[these], self.hits.u[these], self.hits.v[these])
            yield Block(self.first + a, visible, hits)


class Visibility(Described):
    """Visibility of a mesh's vertices, in a folder.

    A folder that holds it already, in whole or in part, is continued; one that holds that of something else
    is refused. Other arguments are taken as they are: `shrm.transfer.precompute` checks them.

    Parameters
    ----------
    folder : path
        Made if it is not there.
    vertices : (V, 3) float64
    faces : (T, 3) int32
        Indices of vertices, in [0, V).
    frames : (V, 3, 3) float64
        Rotations global_from_local of the vertices, see `shrm.transfer.tangent_frames.vertex_frames`.
    directions : (D, 3) float64
        Unit vectors in local coordinates, z >= 0, of equal solid angles 2 pi / D; D a multiple of 8. See
        `shrm.transfer.rays.directions.local_directions`.
    hits : bool
        Whether blocked rays' ends are kept, for light that is reflected.
    block : int
        Vertices of a block, at least 1.

    Attributes
    ----------
    blocks : int
        How many there are in all.
    finished : int
        How many of them are computed.

    Raises
    ------
    ValueError
        If the folder holds the visibility of something else, or a damaged one.
    OSError
        If the folder cannot be made or read.
    """

    shown = ("folder", "vertices", "faces", "hits", "blocks", "finished")

    def __init__(
        self,
        folder: PathLike,
        vertices: FloatArray,
        faces: Int32Array,
        frames: FloatArray,
        directions: FloatArray,
        *,
        hits: bool = False,
        block: int = 512,
    ) -> None:
        self.folder = Path(folder)
        self.vertices, self.frames, self.directions = vertices, frames, directions
        self.faces = np.ascontiguousarray(faces, np.int32)  # other types have another checksum
        self.hits, self.block = hits, block
        self.blocks = -(-len(self.vertices) // self.block)
        self._about = self._parameters()
        self._sizes = self._opened()

    @property
    def finished(self) -> int:
        """Number of blocks that are computed."""
        return len(self._sizes)

    def compute(self, progress: Callable[[int, int], None] | None = None) -> None:
        """Compute the blocks that are missing.

        Parameters
        ----------
        progress : callable, optional
            Called with the vertices done and their number: at the start, and when a block is in the folder.
            What it raises ends the computation and loses nothing.

        Raises
        ------
        OSError
            If the folder cannot be written.
        """
        # What is there already
        total = len(self.vertices)
        if progress is not None:
            progress(min(total, self.finished * self.block), total)
        if self.finished == self.blocks:
            return

        # Block after block: its file first, then the state that names it
        occluders = Occluders(self.vertices, self.faces, self.frames[:, :, 2])
        for index in range(self.finished, self.blocks):
            these = slice(index * self.block, min(total, (index + 1) * self.block))
            visible, hits = occluders.cast(these, self.frames[these], self.directions, hits=self.hits)
            arrays: dict[str, Any] = {"visible": np.packbits(visible, axis=1)}
            if hits is not None:
                u, v = (np.rint(_PLACES * place).astype(np.uint16) for place in (hits.u, hits.v))
                arrays |= {"face": hits.face, "u": u, "v": v}
            content = io.BytesIO()
            np.savez(content, **arrays)
            write_bytes(self._path(index), content.getbuffer())
            self._write_state([*self._sizes, content.getbuffer().nbytes])
            if progress is not None:
                progress(these.stop, total)

    def __len__(self) -> int:
        return self.blocks

    def __iter__(self) -> Iterator[Block]:
        return (self[index] for index in range(self.blocks))

    def __getitem__(self, index: int) -> Block:
        """Read a block.

        Raises
        ------
        IndexError
            If there is no such block.
        ValueError
            If it is not computed yet, or its file is damaged.
        OSError
            If its file is not there.
        """
        # The block, which must be there
        if not 0 <= index < self.blocks:
            raise IndexError(f"block {index} is not among the {self.blocks} there are")
        if index >= self.finished:
            raise ValueError(
                f"{self.folder}: {self.finished} of {self.blocks} blocks are computed: compute first"
            )

        path, first = self._path(index), index * self.block
        B, D = min(self.block, len(self.vertices) - first), len(self.directions)
        content = path.read_bytes()

        # Its arrays, which must be of the shapes and in the ranges that were written
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
                visible = np.unpackbits(_checked(arrays["visible"], np.uint8, B, D // 8), axis=1).view(
                    np.bool_
                )
                if not self.hits:
                    return Block(first, visible, None)
                H = visible.size - int(np.count_nonzero(visible))
                face = _checked(arrays["face"], np.int32, H)
                u, v = (_checked(arrays[name], np.uint16, H) for name in ("u", "v"))
        except Exception as fault:  # numpy and zipfile raise whatever a broken file makes them raise
            raise self._damaged(path) from fault
        if H and not -1 <= face.min() <= face.max() < len(self.faces):
            raise self._damaged(path)
        scale = np.float32(1 / _PLACES)
        return Block(first, visible, Hits(face, u * scale, v * scale))

    def _parameters(self) -> dict[str, object]:
        """Return what the visibility depends on, as the folder says it."""
        return {
            "format": "shrm visibility",
            "version": VERSION,
            "embreex": version("embreex"),
            "vertices": len(self.vertices),
            "faces": len(self.faces),
            "directions": len(self.directions),
            "hits": self.hits,
            "block": self.block,
            "mesh_sha256": digest(self.vertices, self.faces),
            "frames_sha256": digest(self.frames),
            "directions_sha256": digest(self.directions),
        }

    def _opened(self) -> list[int]:
        """Return the sizes in bytes of the blocks that are finished; begin a new folder."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for left in self.folder.glob(".visibility*.part"):  # by a process that was killed as it wrote
            left.unlink(missing_ok=True)
        path = self.folder / _STATE
        if not path.exists():
            self._write_state([])
            return []
        try:
            state = json.loads(path.read_bytes())
            sizes = [whole_number("size", size, 1) for size in state.pop("finished")]
        except (ValueError, TypeError, KeyError, AttributeError) as fault:
            raise self._damaged(path) from fault

        # The same mesh, directions and versions, and all blocks that it names
        other = [name for name in {**self._about, **state} if state.get(name) != self._about.get(name)]
        if other:
            raise ValueError(
                f"{self.folder}: holds the visibility of something else ({', '.join(other)} differ): "
                "take another folder, or remove this one"
            )
        if len(sizes) > self.blocks:
            raise self._damaged(path)
        for index, size in enumerate(sizes):
            block = self._path(index)
            if not block.exists() or block.stat().st_size != size:
                raise self._damaged(block)
        return sizes

    def _write_state(self, sizes: list[int]) -> None:
        """Write how large the blocks are that are finished."""
        text = json.dumps({**self._about, "finished": sizes}, indent=1)
        write_bytes(self.folder / _STATE, (text + "\n").encode())
        self._sizes = sizes

    def _path(self, index: int) -> Path:
        """Return the path of a block."""
        return self.folder / f"visibility_{index:05d}.npz"

    def _damaged(self, path: Path) -> ValueError:
        """Return the error of a file of the folder that is not as it was written."""
        return ValueError(f"{path}: missing, cut short or damaged: remove {self.folder} and compute it again")


def digest(*arrays: npt.NDArray[Any]) -> str:
    """Return what tells arrays apart: the SHA-256 of their bytes."""
    sha = hashlib.sha256()
    for array in arrays:
        sha.update(np.ascontiguousarray(array).data)
    return sha.hexdigest()


def _checked(array: npt.NDArray[Any], dtype: npt.DTypeLike, *shape: int) -> npt.NDArray[Any]:
    """Return an array of a file; refuse one of another type or shape."""
    if array.dtype != dtype or array.shape != shape:
        raise ValueError(f"{array.dtype} {array.shape}")
    return array
