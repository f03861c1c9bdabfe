"""Everything that the window shows, and its file."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.frequency.orders import require_orders, require_tolerance
from shrm.frequency.prefilter import Window
from shrm.render.tangents import Tangents
from shrm.validation import one_of, rotation, whole_number
from shrm.viewer.gpu.scene import Viewer
from shrm.viewer.window.orbit import Orbit

Method = Literal["shrm", "kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral", "hardware"]
Shown = Literal["maps", "integration", "difference"]
Variant = Literal["unshadowed", "shadowed", "interreflected"]
Up = Literal["y", "z"]
Rows = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

UNTURNED: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
GOLD = "ggx(alpha=0.3,f0=1/0.71/0.29)"
FORMAT = "shrm view 1"
LEAST_TENTS = 2


@dataclass(frozen=True)
class State:
    """What the window shows and how; a file of it brings the picture back.

    Attributes
    ----------
    environment : str
        A picture's path, or "daylight".
    layout : str, optional
        The picture's layout, if it is not the one recognised.
    repair : bool
        Whether its texels that are not finite are replaced by neighbours; they are refused otherwise.
    materials : tuple of str
        One for each object, as `shrm.brdf.parse` reads them.
    mesh : str, optional
        A mesh's path; spheres without one.
    up : {"y", "z"}
        The mesh file's upward axis.
    tangents : {"axis", "uv", "principal"}
        The mesh's tangent field, which materials about the tangent use (`shrm.render.Mesh.with_tangents`).
    tolerance : float
        Relative RMS error wanted of the reflected light; chooses the orders.
    orders : (F, P), optional
        The orders themselves, in place of a tolerance.
    method : {"shrm", "kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral", "hardware"}
        All that the orders hold of the reflected light; the same without the azimuth of the view
        (`shrm.explicit.without_azimuth`); by the techniques of `shrm.prefiltered`; or filtered on the GPU
        (`shrm.viewer.HardwarePrefilter`).
    viewer : {"distant", "near"}
        One dynamic map per frame [RH02 eq. 12], or all maps summed in every pixel [RH02 eq. 6, 7].
    shown : {"maps", "integration", "difference"}
        The picture from reflection maps, by direct integration, or the absolute difference of both.
    automatic : bool
        Whether the exposure is found from the picture when light, material or mesh change.
    exposure : float
        In stops.
    background : bool
        Whether the environment is seen behind the objects.
    light : 3 x 3 floats
        How the light is turned, L'(w) = L(R^T w).
    eye : Orbit, optional
        Where it is seen from; without one, so that everything is in the picture.
    selected : int
        The object whose material the panel shows.
    transfer : str, optional
        The path of an object with transfer (`shrm transfer`), in place of the objects that mesh and
        materials describe.
    variant : {"unshadowed", "shadowed", "interreflected"}, optional
        Of its transfer; without one, or where it has none such, the most complete that it has.
    components : int, optional
        How many of its components are used, K; all without one or where it has fewer.
    tents : int, optional
        How many tents there are to a side, M; as it has them without one or where it has fewer.
    window : {"hann", "lanczos"}, optional
        What damps the higher degrees of its light, so that it does not ring.
    turning : bool
        Whether the light turns about the vertical by itself.

    Raises
    ------
    TypeError, ValueError
        If a value is not as described.
    """

    environment: str = "daylight"
    layout: str | None = None
    repair: bool = False
    materials: tuple[str, ...] = (GOLD,)
    mesh: str | None = None
    up: Up = "y"
    tangents: Tangents = "axis"
    tolerance: float = 0.06
    orders: tuple[int, int] | None = None
    method: Method = "shrm"
    viewer: Viewer = "distant"
    shown: Shown = "maps"
    automatic: bool = True
    exposure: float = 0.0
    background: bool = True
    light: Rows = UNTURNED
    eye: Orbit | None = field(default=None)
    selected: int = 0
    transfer: str | None = None
    variant: Variant | None = None
    components: int | None = None
    tents: int | None = None
    window: Window | None = None
    turning: bool = False

    def __post_init__(self) -> None:
        for name in ("environment", "layout", "mesh", "transfer"):
            value = getattr(self, name)
            if not isinstance(value, str) and (value is not None or name == "environment"):
                raise TypeError(f"{name} must be a text, got {value!r}")
        if self.eye is not None and not isinstance(self.eye, Orbit):
            raise TypeError(f"eye must be an Orbit, got {self.eye!r}")
        if not isinstance(self.materials, tuple) or not self.materials:
            raise ValueError(f"materials must be one text or more, got {self.materials!r}")
        if not all(isinstance(text, str) for text in self.materials):
            raise ValueError(f"materials must be one text or more, got {self.materials!r}")
        one_of("up", self.up, get_args(Up))
        one_of("tangents", self.tangents, get_args(Tangents))
        one_of("method", self.method, get_args(Method))
        one_of("viewer", self.viewer, get_args(Viewer))
        one_of("shown", self.shown, get_args(Shown))
        require_tolerance(self.tolerance)
        if self.orders is not None:
            if len(self.orders) != 2:
                raise ValueError(f"orders must be F and P, got {self.orders!r}")
            require_orders(*self.orders)
        if isinstance(self.exposure, bool) or not -100.0 <= self.exposure <= 100.0:
            raise ValueError(f"exposure must be from -100 to 100 stops, got {self.exposure!r}")
        for name in ("automatic", "background", "repair", "turning"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"{name} must be true or false, got {getattr(self, name)!r}")
        rotation("light", self.light)
        if not isinstance(self.selected, int) or not 0 <= self.selected < len(self.materials):
            raise ValueError(f"selected must be from 0 to {len(self.materials) - 1}, got {self.selected!r}")
        if self.variant is not None:
            one_of("variant", self.variant, get_args(Variant))
        if self.window is not None:
            one_of("window", self.window, get_args(Window))
        for name, least in (("components", 1), ("tents", LEAST_TENTS)):
            if getattr(self, name) is not None:
                whole_number(name, getattr(self, name), least)

    @property
    def R(self) -> FloatArray:
        """The light's rotation, (3, 3) float64."""
        return np.asarray(self.light, np.float64)

    def with_light(self, R: FloatArray) -> State:
        """Return it with the light turned otherwise."""
        a, b, c = ((float(x), float(y), float(z)) for x, y, z in R)
        return replace(self, light=(a, b, c))

    def with_material(self, index: int, text: str) -> State:
        """Return it with another material of an object."""
        materials = (*self.materials[:index], text, *self.materials[index + 1 :])
        return replace(self, materials=materials)

    def save(self, path: str | Path) -> None:
        """Write a JSON file.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        text = json.dumps({"format": FORMAT, **asdict(self)}, indent=2)
        Path(path).write_text(text + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> State:
        """Read what `save` wrote.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no such file; the text names the file and what is wrong.
        """
        text = Path(path).read_bytes()
        try:
            try:
                values = json.loads(text.decode("utf-8"))
            except (ValueError, RecursionError):
                values = None
            if not isinstance(values, dict) or values.pop("format", None) != FORMAT:
                raise ValueError("it is no saved window")
            unknown = sorted(values.keys() - {item.name for item in fields(cls)})
            if unknown:
                raise ValueError(f"{unknown[0]!r} is unknown")
            return cls(**_from_json(values))
        except (ValueError, TypeError, KeyError, OverflowError) as fault:
            raise ValueError(f"{path}: {fault}") from None


def _from_json(values: dict[str, Any]) -> dict[str, Any]:
    """Lists as the tuples they were."""
    values = dict(values)
    for name in ("materials", "orders"):
        if isinstance(values.get(name), list):
            values[name] = tuple(values[name])
    if isinstance(values.get("light"), list):
        values["light"] = tuple(tuple(map(float, row)) for row in values["light"])
    if isinstance(values.get("eye"), dict):
        eye = dict(values["eye"])
        target = tuple(map(float, eye.pop("target", (0.0, 0.0, 0.0))))
        values["eye"] = Orbit(target=target, **{name: float(value) for name, value in eye.items()})  # type: ignore[arg-type]
        _ = values["eye"].camera  # whose checks are these values'
    return values
