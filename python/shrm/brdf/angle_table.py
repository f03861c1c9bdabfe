"""Regular tables over the angles of light and view, interpolated linearly.

    axes="angles"       values[i, j, k] at theta_i, theta_o in [0, pi/2], phi = |phi_i - phi_o| in [0, pi]
    axes="half-angle"   values[i, j, k] at theta_h, theta_d in [0, pi/2], phi_d = |phi_d| in [0, pi]

theta_h is the angle of the half vector from the normal, (theta_d, phi_d) the direction of L in the frame of
H, whose x axis leads away from the normal [R98]. Exchanging L and V turns phi_d into pi - phi_d.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import FloatArray, IntArray
from shrm.brdf.value import Value

Axes = Literal["angles", "half-angle"]


@dataclass(frozen=True, eq=False, repr=False)
class AngleTable(Value):
    """Values on a grid over three angles.

    Attributes
    ----------
    values : (n1, n2, n3, channels) float32 or float64
        In C order, finite; 1 or 3 channels; n >= 2. Not checked here, and read-only from now on.
    axes : {"angles", "half-angle"}
        What the angles are.
    nodes : {"ends", "centers"}
        Whether the first and last nodes lie on the ends of the interval, or the nodes are the centers of n
        even bins; beyond the outer centers their values hold.
    warp : {"uniform", "square-root"}
        What the first angle's nodes are even in: the angle, or its square root as in MERL's tables, which
        gathers them about the normal.
    """

    values: npt.NDArray[np.floating[Any]]
    axes: Axes
    nodes: Literal["ends", "centers"] = "ends"
    warp: Literal["uniform", "square-root"] = "uniform"

    def __post_init__(self) -> None:
        self.values.setflags(write=False)

    def __call__(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Interpolate.

        Parameters
        ----------
        wi, wo : (n, 3) float64
            Unit vectors to the light and to the eye, in memory of any strides.

        Returns
        -------
        (n, channels) float64
        """
        return _core.interpolate_angles(table=self.values, **self._grid, wi=wi, wo=wo)

    def nearest(self, wi: FloatArray, wo: FloatArray) -> IntArray:
        """Return the index of the nearest node, (n,), into an array (n1 n2 n3,)."""
        return _core.nearest_angles(shape=self.values.shape[:3], **self._grid, wi=wi, wo=wo)

    @property
    def _grid(self) -> dict[str, Any]:
        return {
            "axes": self.axes,
            "centers": self.nodes == "centers",
            "square_root": self.warp == "square-root",
        }
