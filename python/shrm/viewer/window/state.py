"""Everything that the window shows, and its file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.files import PathLike
from shrm.frequency.orders import require_orders
from shrm.frequency.request import Window
from shrm.render.camera import Viewer
from shrm.render.tangents import Tangents
from shrm.validation import flag, number, one_of, positive, require_instance, rotation, string, whole_number
from shrm.viewer.window.orbit import Orbit

Technique = Literal["shrm", "kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"]
Filter = Literal["two-pass", "exact"]
Shown = Literal["maps", "integration", "difference"]
Variant = Literal["unshadowed", "shadowed", "interreflected"]
Up = Literal["y", "z"]
Rows = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

UNTURNED: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
GOLD = "ggx(alpha=0.3,f0=1/0.71/0.29)"
FORMAT = "shrm view 2"
LEAST_TENTS = 2
FILTERED: Technique = "kautz-mccool-2d"
"""The technique whose maps the GPU can filter: one round lobe, times a factor of the view."""


@dataclass(frozen=True)
class State:
    """What the window shows and how; a file of it brings the picture back.

    Attributes
    ----------
    environment : str
        A picture's path, or "daylight".
    layout : str, optional
        The picture's layout, if it is not the one recognised.
    border : int, optional
        Texels around the faces of its dual paraboloid, if they are not those that it states.
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
    technique : {"shrm", "kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"}
        The class of maps: spherical harmonic reflection maps, the same without the azimuth of the view
        (`shrm.explicit.without_azimuth`), or one of the other classes of `shrm.prefiltered`.
    filter : {"two-pass", "exact"}, optional
        How the GPU filters the maps (`shrm.viewer.HardwarePrefilter`), which "kautz-mccool-2d" alone allows;
        without one they are made of the reflection maps.
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
    border: int | None = None
    repair: bool = False
    materials: tuple[str, ...] = (GOLD,)
    mesh: str | None = None
    up: Up = "y"
    tangents: Tangents = "axis"
    tolerance: float = 0.06
    orders: tuple[int, int] | None = None
    technique: Technique = "shrm"
    filter: Filter | None = None
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
        for name, check in CHECKS.items():
            check(name, getattr(self, name))
        whole_number("selected", self.selected, 0, len(self.materials) - 1)
        if self.filter is not None and self.technique != FILTERED:
            raise ValueError(f"technique must be {FILTERED} with a filter, got {self.technique!r}")

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

    def save(self, path: PathLike) -> None:
        """Write a JSON file.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        text = json.dumps({"format": FORMAT, **asdict(self)}, indent=2)
        Path(path).write_text(text + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: PathLike) -> State:
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
                raise ValueError("not a saved window")
            unknown = sorted(values.keys() - {item.name for item in fields(cls)})
            if unknown:
                raise ValueError(f"unknown field {unknown[0]!r}")
            return cls(**_from_json(values))
        except (ValueError, TypeError, KeyError, OverflowError) as fault:
            raise ValueError(f"{path}: {fault}") from None


Check = Callable[[str, Any], object]
"""Refuses the value of a field, by its name, with a TypeError or a ValueError."""


def _optional(check: Check) -> Check:
    return lambda name, value: None if value is None else check(name, value)


def _choice(literal: Any) -> Check:
    return lambda name, value: one_of(name, value, get_args(literal))


def _texts(name: str, value: Any) -> None:
    if not isinstance(value, tuple) or not value or not all(isinstance(text, str) for text in value):
        raise ValueError(f"{name} must be one string or more, got {value!r}")


def _orders(name: str, value: Any) -> None:
    if len(value) != 2:
        raise ValueError(f"{name} must be F and P, got {value!r}")
    require_orders(*value)


CHECKS: Mapping[str, Check] = {
    "environment": string,
    **dict.fromkeys(("layout", "mesh", "transfer"), _optional(string)),
    "border": _optional(lambda name, value: whole_number(name, value, 0, 8192)),
    **dict.fromkeys(("repair", "automatic", "background", "turning"), flag),
    "materials": _texts,
    "up": _choice(Up),
    "tangents": _choice(Tangents),
    "tolerance": lambda name, value: positive(name, value, 1.0),
    "orders": _optional(_orders),
    "technique": _choice(Technique),
    "filter": _optional(_choice(Filter)),
    "viewer": _choice(Viewer),
    "shown": _choice(Shown),
    "exposure": lambda name, value: number(name, value, -100.0, 100.0),
    "light": rotation,
    "eye": _optional(lambda name, value: require_instance(name, value, Orbit)),
    "variant": _optional(_choice(Variant)),
    "components": _optional(lambda name, value: whole_number(name, value, 1)),
    "tents": _optional(lambda name, value: whole_number(name, value, LEAST_TENTS)),
    "window": _optional(_choice(Window)),
}
"""What each field must be, whatever the others are."""


def _from_json(values: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a state as JSON has them with tuples where it has lists."""
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
