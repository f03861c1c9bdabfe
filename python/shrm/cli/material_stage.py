"""A row of objects of prefiltered materials, as `shrm render` draws it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Literal

from shrm.arrays import FloatArray
from shrm.cli.console import progress
from shrm.cli.options import largest_orders, read_mesh
from shrm.cli.stage import GPU_MAP_SIZE, Stage

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.frequency.reflection_map import ReflectionMap
    from shrm.frequency.relight import Prefilter
    from shrm.render import Camera, Object, SupportsRadiance
    from shrm.result_files import Result

FREQUENCY_TOLERANCE = 0.05
"""Default tolerance in frequency space, the relative RMS error of the reflected radiance."""

INTEGRATION_TOLERANCE = 0.01
"""Default tolerance of the hierarchical method, and of earlier techniques, whose maps it integrates."""


class MaterialStage(Stage):
    """Objects in a row, their light and the camera, as the options of `shrm render` have them."""

    def __init__(self, row: list[BRDF | Result], options: argparse.Namespace) -> None:
        from shrm.render import Sphere

        super().__init__(options, len(row))
        mesh = None if options.mesh is None else read_mesh(options)
        self._shapes = [
            Sphere(center) if mesh is None else mesh.placed(center, turn=options.turn)
            for center in self.centers
        ]
        self._materials = [self._prefiltered(material) for material in row]

    def _prefiltered(self, material: BRDF | Result) -> Prefilter | SupportsRadiance:
        """Prefilter a material by the method or technique that the options name."""
        from shrm.brdf import BRDF
        from shrm.integrate.angular import prefilter_angular
        from shrm.integrate.hierarchical import prefilter_hierarchical
        from shrm.prefiltered import prefilter as prefilter_earlier

        if not isinstance(material, BRDF):
            return material
        options, layout, size = self.options, *self._grid()
        with progress(f"Prefiltering with {material.name}"):
            automatic = options.method == "auto"
            tolerance = options.tolerance or (FREQUENCY_TOLERANCE if automatic else INTEGRATION_TOLERANCE)
            if options.technique != "shrm":
                return prefilter_earlier(
                    self.env,
                    material,
                    technique=options.technique,
                    tolerance=tolerance,
                    layout=layout,
                    size=size,
                )
            method = self._cheapest(material, tolerance) if automatic else options.method
            if method == "angular":
                return prefilter_angular(self.env, material, tolerance=tolerance if automatic else None)
            if method == "hierarchical":
                return prefilter_hierarchical(self.env, material, tolerance=tolerance)
            return self._in_frequency_space(material)

    def _cheapest(self, material: BRDF, tolerance: float) -> str:
        """Return the method that is predicted to cost least for the pictures that are drawn, to a tolerance.

        Radiance is asked for at every sample of every pixel, by a distant viewer too, as if each object
        filled its share of the picture.
        """
        from shrm.methods.cost import cheapest

        F_max, P_max = largest_orders(self.options)
        H, W = self.shape
        return cheapest(
            self.env,
            material,
            tolerance=tolerance,
            points=self.frames * self.options.samples**2 * H * W // len(self.centers),
            F_max=F_max,
            P_max=P_max,
        )

    def _in_frequency_space(self, material: BRDF) -> Prefilter | ReflectionMap:
        """Prefilter in frequency space, so that the light can be turned if it is to be."""
        from shrm.frequency.prefilter import prefilter
        from shrm.frequency.relight import Prefilter

        options, layout, size = self.options, *self._grid()
        F_max, P_max = largest_orders(options)
        make = Prefilter if options.turntable == "light" else prefilter
        return make(
            self.env,
            material,
            tolerance=options.tolerance or FREQUENCY_TOLERANCE,
            orders=options.orders,
            F_max=F_max,
            P_max=P_max,
            residual=options.residual,
            layout=layout,
            size=size,
        )

    def _grid(self) -> tuple[Literal["latlong", "cube"], int | None]:
        """Return the layout and the size of maps."""
        return ("cube", GPU_MAP_SIZE) if self.options.gpu else ("latlong", None)

    def objects(self, rotation: FloatArray, camera: Camera) -> list[Object]:
        """Return the objects under light turned by a rotation (3, 3); maps that were saved are not turned."""
        from shrm.frequency.relight import Prefilter
        from shrm.render import Object

        maps = [
            material.update(rotation=rotation) if isinstance(material, Prefilter) else material
            for material in self._materials
        ]
        return [Object(shape, each, self.texture) for shape, each in zip(self._shapes, maps, strict=True)]
