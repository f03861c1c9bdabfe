"""Relighting: a reflection map that follows its light.

What depends on the sizes, the orders and the material alone is made once. A frame then takes an analysis (or
none, if the light has only turned: its coefficients are rotated), a product and a synthesis [RH02 section
6.1, appendix C].
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from shrm import _core, sh
from shrm.arrays import Float16Array, Float32Array, FloatArray
from shrm.brdf import BRDF, require_brdf
from shrm.environment import Environment, require_environment
from shrm.frequency.analysis import LobeAnalysis
from shrm.frequency.expansion import expansion_for, windowed
from shrm.frequency.part import Part
from shrm.frequency.prediction import Prediction, Truncation
from shrm.frequency.prefilter import reflection_map
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.request import Request, Window, centered, method_takes
from shrm.frequency.rings import empty_halves, require_half_range
from shrm.validation import require_shape
from shrm.validation import rotation as checked_rotation


class Prefilter:
    """A prefiltered environment that is updated in place.

    Parameters
    ----------
    env : Environment
        The first light; later ones have its size.
    brdf : BRDF
        The material.
    tolerance, orders, criterion, size, layout, center, F_max, P_max, window, clamp, half, residual
        As in `shrm.prefilter`. A tolerance chooses the orders, and what is split off, for the first light;
        later ones keep them.

    Attributes
    ----------
    map : ReflectionMap
        The reflection map of the last update. What updates return shares this object's memory: the next one
        overwrites the maps. `error` is predicted for the light and material it was made from.

    Notes
    -----
    One thread at a time may update it.

    Raises
    ------
    TypeError, ValueError
        As `shrm.prefilter`.

    Examples
    --------
    >>> import numpy as np
    >>> from shrm import Environment, Prefilter, brdf
    >>> env = Environment.daylight(size=64)
    >>> relit = Prefilter(env, brdf.GGX(0.3), orders=(12, 2), size=16, layout="cube")
    >>> turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> relit.update(rotation=turn).at_view([0.0, 0.0, 1.0]).shape
    (6, 16, 16, 3)
    """

    @method_takes(Request)
    def __init__(self, request: Request) -> None:
        self._expansion = expansion_for(request)
        self.map = reflection_map(request, self._expansion)
        assert isinstance(self.map.prediction, Prediction)
        self._cores_error = self.map.prediction.cores

        # The material and where its lobes are put, the light as it was given, and its rotation
        self._material = request.brdf
        self._center = request.center
        self._env = request.env
        self._rotation: FloatArray | None = None
        self._light = request.env.coefficients(self.map.F).copy()
        self._prepare()

    def _prepare(self) -> None:
        """Make the tables and the memory that updates use."""
        H, W, _ = self._env.pixels.shape
        self._analysis = sh.Plan((H, W), self.map.F, areas=True)
        self._next_light = np.empty_like(self._light)
        self._rotate = _core.Rotation(F=self.map.F, channels=3)
        self._rotated = np.empty_like(self._light)
        self._plans = [_LobePlan(part) for part in self.map.expanded_parts()]

    def update(
        self,
        env: Environment | None = None,
        *,
        rotation: npt.ArrayLike | None = None,
        brdf: BRDF | None = None,
    ) -> ReflectionMap:
        """Make the map anew from what has changed; what is not given stays.

        Parameters
        ----------
        env : Environment, optional
            Another light, of the same size, not rotated unless `rotation` says so.
        rotation : (3, 3) array_like, optional
            Rotates the last environment that was given, L'(w) = L(R^T w), as `Environment.rotated` but in the
            coefficients: no texel is touched. It replaces an earlier rotation.
        brdf : BRDF, optional
            Another material, with lobes of the same kinds about the same centers; not beside a residual.

        Returns
        -------
        ReflectionMap
            The attribute `map`.

        Raises
        ------
        TypeError, ValueError
            If the light has another size, R is no rotation, the material has other lobes or there is a
            residual, or half floats do not reach the values of the new maps. The map stays as it was.
        """
        # What has changed, checked
        if env is not None:
            require_environment(env)
            require_shape("env", env.pixels, self._env.pixels.shape)
        R = self._rotation if env is None else None
        if rotation is not None:
            R = checked_rotation("rotation", rotation).copy()
        material = self._material if brdf is None else self._of_the_same_kind(brdf)

        # The light's coefficients
        light = self._light
        if env is not None:
            light = self._analysis.analysis(env.pixels, out=self._next_light)
        rotated = light
        if R is not None:
            self._rotate.run(light, R, self._rotated)
            rotated = self._rotated

        # Those of the lobes, and the maps
        expansion = self._expansion
        tables = [(plan.part.gamma, plan.part.rho) for plan in self._plans]
        if brdf is not None:
            expansion = replace(expansion, material=material, smooth=material)
            pairs = zip(self._plans, expansion.analyses(), strict=True)
            tables = [plan.tables_of(lobe, expansion.window) for plan, lobe in pairs]
        for plan, (_, rho) in zip(self._plans, tables, strict=True):
            plan.compute(rotated, rho)

        # Nothing is refused any more: keep all of it.
        if env is not None:
            self._env, self._light, self._next_light = env, light, self._light
        self._rotation, self._material, self._expansion = R, material, expansion
        parts = tuple(
            plan.keep(rotated, gamma, rho) for plan, (gamma, rho) in zip(self._plans, tables, strict=True)
        )
        residual = self.map.residual
        if residual is not None:
            residual = residual if env is None else residual.relit(env.pixels)
            residual = residual.rotated(np.eye(3) if R is None else R)
        truncation = Truncation(self._env, expansion)
        prediction = Prediction(truncation, parts, self._cores_error, look_up=False)
        self.map = replace(
            self.map, parts=parts, brdf=material.name, prediction=prediction, residual=residual
        )
        return self.map

    def _of_the_same_kind(self, brdf: BRDF) -> BRDF:
        """Return another material about this one's centers; ValueError if its lobes are of other kinds."""
        if self._expansion.cores is not None:
            raise ValueError(
                "brdf cannot change beside a residual, which is split off for one: prefilter anew"
            )
        require_brdf(brdf)
        material = centered(brdf, self._center)
        kinds = [(type(lobe), lobe.center) for lobe in material.lobes]
        if kinds != [(type(lobe), lobe.center) for lobe in self._material.lobes]:
            raise ValueError(f"brdf must have lobes as those of {self._material!r}, got {material!r}")
        return material

    def __getstate__(self) -> dict[str, object]:
        """Return what is pickled: tables and memory are made again."""
        return {name: value for name, value in self.__dict__.items() if name not in _PREPARED}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._prepare()

    def __repr__(self) -> str:
        H, W, _ = self._env.pixels.shape
        return f"<Prefilter of {H} x {W} texels: {self.map!r}>"


_PREPARED = ("_analysis", "_next_light", "_rotate", "_rotated", "_plans")
"""Attributes that `Prefilter._prepare` makes, and that are not pickled."""


class _LobePlan:
    """The maps of one lobe, in memory that is used again.

    An update computes the maps of all lobes, which may be refused, and only then keeps them: until then maps
    of half floats are those of the last update.

    Attributes
    ----------
    part : Part
        The part of the last update.
    """

    def __init__(self, part: Part) -> None:
        self.part = part
        H, maps, _, W = part.rings.shape
        J = part.F if part.zonal else part.F + part.P
        self._product = _core.MapCoefficients(F=part.F, P=part.P, channels=3, zonal=part.zonal)
        self._rho: FloatArray | None = None  # what _product holds
        self._coefficients = np.empty((sh.basis_size(J), maps, 3))
        self._synthesis: _core.CubeSynthesis | _core.Synthesis
        if part.layout == "cube":
            self._synthesis = _core.CubeSynthesis(N=part.size, channels=3 * maps, F=J)
        else:
            self._synthesis = _core.Synthesis(H=H, W=W, channels=3 * maps, F=J)
        self._rings = np.empty((H, maps, 3, W), dtype=np.float32)
        half = part.rings.dtype == np.float16
        self._halves = empty_halves(part.rings.shape, part.layout) if half else None

    def tables_of(self, lobe: LobeAnalysis, window: Window | None) -> tuple[FloatArray, FloatArray]:
        """Return gamma and rho of another lobe of the same kind."""
        return lobe.gamma, windowed(lobe, self.part.F, self.part.P, window)

    def compute(self, light: FloatArray, rho: FloatArray) -> None:
        """Make the maps for light of degree F or more; ValueError if half floats do not reach them."""
        if rho is not self._rho:
            self._product.set_material(rho)
            self._rho = rho
        self._product.run(light[: sh.basis_size(self.part.F)], self._coefficients)
        H, maps, _, W = self._rings.shape
        flat = self._coefficients.reshape(len(self._coefficients), 3 * maps)
        self._synthesis.run(flat, self._rings.reshape(H, 3 * maps, W))
        if self._halves is not None:
            require_half_range(self._rings)

    def keep(self, light: FloatArray, gamma: FloatArray, rho: FloatArray) -> Part:
        """Return the maps computed, with what they were computed from."""
        rings: Float32Array | Float16Array = self._rings
        if self._halves is not None:
            _core.to_half(self._rings, self._halves)
            rings = self._halves
        own_light = light[: sh.basis_size(self.part.F)].copy()
        self.part = replace(self.part, light=own_light, gamma=gamma, rho=rho, rings=rings)
        return self.part
