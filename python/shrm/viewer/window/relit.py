"""An object with transfer, lit for every frame: its vertices' radiance, by what the state chooses of it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import get_args

from shrm.environment import Environment
from shrm.render.camera import Camera
from shrm.render.transferred import TransferredMesh
from shrm.render.vertex_radiance import VertexRadiance
from shrm.transfer.lighting import Compressed, Lighting
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.viewer.window.state import State, Variant

VARIANTS: tuple[Variant, ...] = get_args(Variant)
"""From the simplest to the most complete."""


@dataclass(frozen=True)
class Choice:
    """What is used of an object with transfer.

    Attributes
    ----------
    variant : str
        A name in its variants.
    K, most_K : int
        Components used, and how many there are; 0 where the variant is not compressed.
    M, most_M : int
        Tents to a side, and how many there are.
    held : tuple of str
        The variants that there are, from the simplest to the most complete.
    """

    variant: Variant
    K: int
    most_K: int
    M: int
    most_M: int
    held: tuple[Variant, ...]

    @classmethod
    def of(cls, state: State, transfer: RadianceTransfer) -> Choice:
        """Return what a state asks for, as far as the object has it."""
        held = tuple(name for name in VARIANTS if name in transfer.variants)
        variant = state.variant if state.variant in held else held[-1]
        most_K, most_M = transfer.variants[variant].K, transfer.M
        if most_K == 0:  # matrices alone, which are not made coarser
            return cls(variant, 0, 0, most_M, most_M, held)
        K, M = min(state.components or most_K, most_K), min(state.tents or most_M, most_M)
        return cls(variant, K, most_K, M, most_M, held)

    @property
    def shadows(self) -> bool:
        """Whether parts of the object take light from others."""
        return self.variant != "unshadowed"

    @property
    def bounces(self) -> bool:
        """Whether parts of the object light others."""
        return self.variant == "interreflected"

    @property
    def other_shadows(self) -> Variant | None:
        """The variant with shadows on or off, the other way; None if there is none."""
        return self._first("unshadowed") if self.shadows else self._first("shadowed", "interreflected")

    @property
    def other_bounces(self) -> Variant | None:
        """The variant with interreflection on or off, the other way; None if there is none."""
        return self._first("shadowed") if self.bounces else self._first("interreflected")

    def _first(self, *variants: Variant) -> Variant | None:
        return next((name for name in variants if name in self.held), None)


class RelitObject:
    """Lights an object with transfer anew when light, eye or choice change.

    Attributes
    ----------
    seconds : float
        What that took last, in numbers: from the light's coefficients to radiance at all vertices.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._lighting: tuple[RadianceTransfer, str, int, Lighting] | None = None
        self._lit: tuple[tuple[object, ...], VertexRadiance] | None = None

    def drawn_with(
        self, placed: TransferredMesh, environment: Environment, state: State, camera: Camera
    ) -> VertexRadiance:
        """Return the radiance at the vertices, the same object as long as it is the same.

        Raises
        ------
        ValueError, MemoryError
            If the object cannot be lit so.
        """
        choice = Choice.of(state, placed.transfer)
        decides = placed, environment, choice, state.light, state.window, state.viewer, camera
        if self._lit is None or self._lit[0] != decides:
            coefficients = environment.coefficients(placed.transfer.n - 1)  # kept with the environment
            lighting = self._chosen(placed.transfer, choice)
            start = time.perf_counter()
            light = placed.light(coefficients, state.R, state.window)
            lit = placed.lit(lighting, light, camera, state.viewer)
            self.seconds = time.perf_counter() - start
            self._lit = decides, lit
        return self._lit[1]

    def _chosen(self, transfer: RadianceTransfer, choice: Choice) -> Lighting:
        """Return what lights the object as chosen; the same for other numbers of components."""
        held = self._lighting
        if held is None or held[0] is not transfer or held[1:3] != (choice.variant, choice.M):
            M = choice.M if choice.K else None
            held = transfer, choice.variant, choice.M, transfer.lighting(choice.variant, tents=M)
            self._lighting = held
        lighting = held[3]
        if isinstance(lighting, Compressed) and choice.K and lighting.K != choice.K:
            lighting.K = choice.K
        return lighting
