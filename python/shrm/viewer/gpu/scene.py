"""What is drawn: objects, the eye, the light behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.render.camera import Camera, Viewer
from shrm.render.picture import Background, Object
from shrm.validation import one_of, require_instance, rotation


@dataclass(frozen=True, eq=False)
class Scene:
    """Objects under one light, seen by one camera.

    Parameters
    ----------
    objects : sequence of shrm.render.Object
        Their materials are reflection maps (`shrm.ReflectionMap`), maps of `shrm.prefiltered`,
        dual-paraboloid maps (`shrm.viewer.ParaboloidMaps`, `shrm.viewer.HardwarePrefilter`), or radiance at
        vertices (`shrm.render.VertexRadiance`).
    camera : shrm.render.Camera
    background : shrm.Environment, optional
        What is seen behind the objects; black without one.
    viewer : {"near", "distant"}
        Each pixel has its own view vector, or all have the camera's [RH02 section 7.5].
    rotation : (3, 3) array_like
        How the background is turned, L'(w) = L(R^T w). (The light of the objects is in their maps.)

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    objects: Sequence[Object]
    camera: Camera
    background: Background | None = None
    viewer: Viewer = "near"
    rotation: FloatArray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        for index, obj in enumerate(self.objects):
            require_instance(f"objects[{index}]", obj, Object)
        require_instance("camera", self.camera, Camera)
        one_of("viewer", self.viewer, get_args(Viewer))
        object.__setattr__(self, "rotation", rotation("rotation", self.rotation))

    def __repr__(self) -> str:
        background = "" if self.background is None else ", background"
        count = len(self.objects)
        return f"<Scene: {count} object{'' if count == 1 else 's'}, {self.viewer} viewer{background}>"
