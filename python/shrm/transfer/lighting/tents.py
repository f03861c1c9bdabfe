"""Lighting from tents' coefficients of outgoing radiance: in full, compressed, or with something fixed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array
from shrm.transfer.lighting.surface import (
    BLOCK,
    Eye,
    Lighting,
    Surface,
    order_of,
    require_channels,
    tents_of,
)
from shrm.validation import StoredArray, float32_array, indices, require_instance, stored_array, whole_number


class Tents(Lighting):
    """Lighting by four rows of each vertex's matrix, of the tents that are not zero at the view [LK03 eq. 9].

    Parameters
    ----------
    vertices : (V, 3) array_like
    frames : (V, 3, 3) array_like
        Rotations global_from_local: columns x = tangent, y, z = normal.
    matrices : (V, M^2, C, n^2) array
        A_p: the tents' coefficients of outgoing radiance from those of light in global coordinates; M in
        [2, 33], n in [1, 10]. C is 1, the same for red, green and blue, or 3. Float32 or float16, which are
        read where they are, mapped files too; others are converted to float32.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    shown = ("matrices",)

    def __init__(self, vertices: npt.ArrayLike, frames: npt.ArrayLike, matrices: npt.ArrayLike) -> None:
        self.surface = Surface(vertices, frames)
        self.matrices = stored_array("matrices", matrices, (self.surface.size, "M^2", "C", "n^2"))
        _, tents, channels, terms = self.matrices.shape
        self.size, self.M, self.n = (
            len(self.matrices),
            tents_of("matrices", tents),
            order_of("matrices", terms),
        )
        require_channels("matrices", channels)

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        _core.light_tents(
            surface=self.surface.core,
            matrices=self.matrices,
            light=light,
            eye=eye.at,
            distant=eye.distant,
            radiance=radiance,
        )

    def coefficients(self, light: Float32Array) -> Float32Array:
        """Return the tents' coefficients of outgoing radiance under a light (n^2, 3): (V, M^2, 3) float32."""
        result = np.empty((self.size, self.M**2, 3), dtype=np.float32)
        for at in _blocks(self.size):
            _times_light(self.matrices[at].astype(np.float32, copy=False), light, result[at])
        return result

    def rows(self, eye: Eye) -> Float32Array:
        """Return the row that light is multiplied by at a view: (V, C, n^2) float32."""
        tents, weights = self.surface.tents(eye, self.M)
        result = np.empty((self.size, *self.matrices.shape[2:]), dtype=np.float32)
        for at in _blocks(self.size):
            chosen = self.matrices[np.arange(at.start, at.stop)[:, None], tents[at]]
            result[at] = np.einsum("vt,vtcj->vcj", weights[at], chosen)
        return result


class Compressed(Lighting):
    """Lighting by principal components, without making the matrices that they sum to [LK03 eqs. 12, 13].

    Parameters
    ----------
    vertices : (V, 3) array_like
    frames : (V, 3, 3) array_like
        Rotations global_from_local: columns x = tangent, y, z = normal.
    weights : (V, k) array
        Float32 or float16.
    components : (k, M^2, C, n^2) or (Q, k, M^2, C, n^2) array
        A_p ~ sum_k weights[p, k] components[k], or those of the vertex's cluster; see `Tents`.
    clusters : (V,) integer array, optional
        The cluster of each vertex, in [0, Q): with components of five dimensions.
    K : int, optional
        How many components are used, the first ones, 1 to k; all if not given.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    shown = ("weights", "components", "clusters", "K")

    def __init__(
        self,
        vertices: npt.ArrayLike,
        frames: npt.ArrayLike,
        weights: npt.ArrayLike,
        components: npt.ArrayLike,
        clusters: npt.ArrayLike | None = None,
        K: int | None = None,
    ) -> None:
        self.surface = Surface(vertices, frames)
        self.weights = stored_array("weights", weights, (self.surface.size, "k"))
        self.size, most = self.weights.shape

        # Components for each cluster, which without clusters is one
        shape = (most, "M^2", "C", "n^2")
        if clusters is None:
            self.components = float32_array("components", components, shape, empty=False)[None]
        else:
            self.components = float32_array("components", components, ("Q", *shape), empty=False)
        Q, _, tents, channels, terms = self.components.shape
        self.clusters = None if clusters is None else indices("clusters", clusters, Q, (self.size,))
        self.M, self.n = tents_of("components", tents), order_of("components", terms)
        require_channels("components", channels)
        self._K = 0
        self.K = most if K is None else K

    @property
    def K(self) -> int:
        """Number of components that are used. It can be set at any time: the first K are copied."""
        return self._K

    @K.setter
    def K(self, K: int) -> None:
        K = whole_number("K", K, 1, self.weights.shape[1])
        if K != self._K:
            self._plan = self._planned(K)
            self._K = K

    def _planned(self, K: int) -> _core.CompressedTransfer:
        """Return what the core makes of the first K components."""
        return _core.CompressedTransfer(
            weights=self.weights, components=self.components, clusters=self.clusters, K=K
        )

    def __getstate__(self) -> dict[str, object]:
        """Return what a pickle holds: all but what the core made."""
        return {name: value for name, value in vars(self).items() if name != "_plan"}

    def __setstate__(self, state: dict[str, object]) -> None:
        vars(self).update(state)
        self._plan = self._planned(self._K)

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        self._plan.run(
            surface=self.surface.core, light=light, eye=eye.at, distant=eye.distant, radiance=radiance
        )

    def coefficients(self, light: Float32Array) -> Float32Array:
        """Return the tents' coefficients of outgoing radiance under a light (n^2, 3): (V, M^2, 3) float32."""
        used = self.components[:, : self.K]
        lit = np.empty((*used.shape[:3], 3), dtype=np.float32)
        _times_light(used, light, lit)
        result = np.empty((self.size, self.M**2, 3), dtype=np.float32)
        for q, members in self._members():
            result[members] = np.tensordot(self._used_weights(members), lit[q], axes=1)
        return result

    def rows(self, eye: Eye) -> Float32Array:
        """Return the row that light is multiplied by at a view: (V, C, n^2) float32."""
        tents, values = self.surface.tents(eye, self.M)
        result = np.empty((self.size, *self.components.shape[3:]), dtype=np.float32)
        for q, members in self._members():
            for at in _blocks(len(members)):
                block = members[at]
                chosen = self.components[q, : self.K, tents[block]]  # (v, t, k, C, n^2)
                w = np.einsum("vt,vk->vtk", values[block], self._used_weights(block))
                result[block] = np.einsum("vtk,vtkcj->vcj", w, chosen, optimize=True)
        return result

    def _members(self) -> list[tuple[int, npt.NDArray[np.intp]]]:
        """Return the clusters that have vertices, and these."""
        if self.clusters is None:
            return [(0, np.arange(self.size))]
        return [(int(q), np.flatnonzero(self.clusters == q)) for q in np.unique(self.clusters)]

    def _used_weights(self, members: npt.NDArray[np.intp]) -> Float32Array:
        """Return the first K weights of some vertices, in float32."""
        return self.weights[members, : self.K].astype(np.float32, copy=False)


class FixedLight(Lighting):
    """Lighting for a light that seldom changes: tents' coefficients once, four a view [LK03 section 3.3].

    Radiance is that of the way of lighting it is made for. A light, or a K, that differs from the last one
    costs all of a vertex's tents, not four.

    Parameters
    ----------
    lighting : Tents or Compressed

    Raises
    ------
    TypeError
        If it is neither.
    """

    shown = ("lighting",)

    def __init__(self, lighting: Tents | Compressed) -> None:
        require_instance("lighting", lighting, Tents, Compressed, what="Tents or Compressed")
        self.lighting, self.size, self.n = lighting, lighting.size, lighting.n
        self._made_for: object = None

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        made_for = _components_of(self.lighting), light.tobytes()
        if self._made_for != made_for:
            self._coefficients, self._made_for = self.lighting.coefficients(light), made_for
        _core.light_fixed_tents(
            surface=self.lighting.surface.core,
            coefficients=self._coefficients,
            eye=eye.at,
            distant=eye.distant,
            radiance=radiance,
        )


class FixedView(Lighting):
    """Lighting for an eye that seldom moves: each vertex's row once, its product a light [LK03 section 3.3].

    Radiance is that of the way of lighting it is made for. An eye, or a K, that differs from the last one
    costs a reading of four rows of every vertex.

    Parameters
    ----------
    lighting : Tents or Compressed

    Raises
    ------
    TypeError
        If it is neither.
    """

    shown = ("lighting",)

    def __init__(self, lighting: Tents | Compressed) -> None:
        require_instance("lighting", lighting, Tents, Compressed, what="Tents or Compressed")
        self.lighting, self.size, self.n = lighting, lighting.size, lighting.n
        self._made_for: object = None

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        made_for = _components_of(self.lighting), eye.distant, eye.at.tobytes()
        if self._made_for != made_for:
            self._rows, self._made_for = self.lighting.rows(eye), made_for
        _core.light_rows(rows=self._rows, light=light, radiance=radiance)


def _components_of(lighting: Tents | Compressed) -> int | None:
    """Return how many components are used, which can be changed; None where there are none."""
    return lighting.K if isinstance(lighting, Compressed) else None


def _times_light(matrices: StoredArray, light: Float32Array, result: Float32Array) -> None:
    """Fill result (..., 3): matrices (..., C, n^2) times light (n^2, 3); one channel serves all three."""
    for c in range(3):
        np.matmul(matrices[..., min(c, matrices.shape[-2] - 1), :], light[:, c], out=result[..., c])


def _blocks(count: int) -> list[slice]:
    """Return slices of at most `BLOCK`, of so many in all."""
    return [slice(start, min(start + BLOCK, count)) for start in range(0, count, BLOCK)]
