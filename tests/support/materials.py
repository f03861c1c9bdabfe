"""Every way to make a material, twice over: as it is, and with one parameter changed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from shrm import brdf

from support import rgl_format


class Making(NamedTuple):
    """Two materials of one constructor."""

    same: Callable[[], brdf.BRDF]
    """Makes an equal material at every call."""
    changed: Callable[[], brdf.BRDF]
    """Makes one that differs in a parameter."""


def glossy(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """An isotropic BRDF without the cosine, (n,)."""
    return np.asarray(1.0 / (1.01 - np.einsum("nc,nc->n", wi * [-1.0, -1.0, 1.0], wo)))


def strands(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """A function of the angles from the tangent, (n, 3)."""
    return np.asarray((1.0 + wi[:, 2:] * wo[:, 2:]) * [1.0, 0.5, 0.25])


def doubled(values: np.ndarray) -> np.ndarray:
    """A profile, or a function of two angles or directions, of its first argument alone."""
    return np.asarray(2.0 * np.abs(values))


def _table(seed: int, shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.1, 1.0, shape)


def _lafortune(z: float) -> brdf.BRDF:
    return brdf.Lafortune([[-1.0] * 3], [[-1.0] * 3], [[z, 0.9, 0.8]], [[3.0, 5.0, 9.0]], diffuse=0.2)


def _abc(B: float) -> brdf.BRDF:
    return brdf.ABC(kD=0.1, A=(10.0, 5.0, 2.0), B=B, C=1.2, ior=1.5)


def _sgd(alpha: float) -> brdf.BRDF:
    return brdf.SGD(0.1, 0.2, alpha, 0.9, 0.04, 0.001, 30.0, 0.1, 0.2, 3.0, 0.5)


MODELS: Mapping[str, Making] = {
    "Lambert": Making(lambda: brdf.Lambert(0.5), lambda: brdf.Lambert(0.6)),
    "Lambert of three": Making(lambda: brdf.Lambert((0.5, 0.4, 0.3)), lambda: brdf.Lambert((0.5, 0.4, 0.2))),
    "Phong": Making(lambda: brdf.Phong(12), lambda: brdf.Phong(13)),
    "Microfacet": Making(lambda: brdf.Microfacet(0.2), lambda: brdf.Microfacet(0.3)),
    "GGX": Making(lambda: brdf.GGX(0.3), lambda: brdf.GGX(0.3, f0=0.9)),
    "GGX of three": Making(lambda: brdf.GGX(0.3, (1, 0.8, 0.3)), lambda: brdf.GGX(0.3, (1, 0.8, 0.2))),
    "Beckmann": Making(lambda: brdf.Beckmann(0.3), lambda: brdf.Beckmann(0.2)),
    "MillerHeidrich": Making(lambda: brdf.MillerHeidrich(0.5, 8), lambda: brdf.MillerHeidrich(0.5, 9)),
    "KajiyaKay": Making(lambda: brdf.KajiyaKay(9), lambda: brdf.KajiyaKay(9, cone="mirror")),
    "Banks": Making(lambda: brdf.Banks(0.5), lambda: brdf.Banks(0.25)),
    "AshikhminShirley": Making(
        lambda: brdf.AshikhminShirley(20, 80, 0.4, 0.3), lambda: brdf.AshikhminShirley(80, 20, 0.4, 0.3)
    ),
    "AnisotropicGGX": Making(lambda: brdf.AnisotropicGGX(0.2, 0.4), lambda: brdf.AnisotropicGGX(0.4, 0.2)),
    "ABC": Making(lambda: _abc(100.0), lambda: _abc(101.0)),
    "SGD": Making(lambda: _sgd(0.1), lambda: _sgd(0.2)),
    "Lafortune": Making(lambda: _lafortune(1.0), lambda: _lafortune(0.99)),
    "Tabulated": Making(
        lambda: brdf.Tabulated(_table(1, (4, 5, 6))), lambda: brdf.Tabulated(_table(2, (4, 5, 6)))
    ),
    "Tabulated over half angles": Making(
        lambda: brdf.Tabulated(_table(1, (4, 5, 6, 3)), "half-angle"),
        lambda: brdf.Tabulated(_table(1, (4, 5, 6, 3)), "angles"),
    ),
    "from_function": Making(
        lambda: brdf.from_function(glossy), lambda: brdf.from_function(glossy, name="another")
    ),
    "from_function about the tangent": Making(
        lambda: brdf.from_function(strands, "tangent"), lambda: brdf.from_function(strands, "tangent", "hair")
    ),
    "Material": Making(
        lambda: brdf.Material((brdf.RadialLobe("normal", doubled),), "mine"),
        lambda: brdf.Material((brdf.RadialLobe("reflection", doubled),), "mine"),
    ),
    "parse": Making(
        lambda: brdf.parse("0.5*lambert:0.8 + ggx:0.2"), lambda: brdf.parse("0.5*lambert:0.8 + ggx:0.3")
    ),
    "a published fit": Making(
        lambda: brdf.parse("merl-abc:blue-metallic-paint"), lambda: brdf.parse("merl-sgd:gold-metallic-paint")
    ),
}
"""Ways to make a material, by the name of the constructor and a word on the variant."""


def derived(material: brdf.BRDF) -> dict[str, brdf.BRDF]:
    """Return sums and products of a material, and the material about other centers where it can be."""
    materials = {
        "sum": material + brdf.Lambert(0.25),
        "product": 0.5 * material,
        "product of three": (1.0, 0.5, 0.25) * material,
    }
    if all(lobe.kind in ("radial", "isotropic") for lobe in material.lobes):
        centers: tuple[Literal["reflection", "normal"], ...] = ("reflection", "normal")
        materials |= {f"about the {center}": material.recentered(center) for center in centers}
        if not any(lobe.kind == "radial" and lobe.center == "reflection" for lobe in material.lobes):
            materials["merged"] = material.recentered("reflection", merge=True)
    return materials


MEASURED = ("MERL", "RGL", "Cornell", "CUReT", "ALTA of one angle", "ALTA of two", "ALTA of three")


def write_measurements(folder: Path, source: str, seed: int = 0) -> Path:
    """Write a small file of measurements in one of the formats of `MEASURED`; numbers that mean nothing."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform(size=(60, 4)) * [1.3, 6.0, 1.3, 6.0]
    if source == "MERL":
        path = folder / "paint.binary"
        table = rng.uniform(-10.0, 100.0, (3, 5, 4, 6))
        path.write_bytes(np.array([5, 4, 6], "<i4").tobytes() + table.astype("<f8").tobytes())
    elif source == "RGL":
        path = folder / "paint.bsdf"
        path.write_bytes(rgl_format.content(rgl_format.random(seed)))
    elif source == "Cornell":
        path = folder / "paint.brdf"
        _write_rows(path, "3\n400 550 700\n", np.concatenate([angles, rng.uniform(size=(60, 3))], axis=1))
    elif source == "CUReT":
        path = folder / "paint.txt"
        _write_rows(path, "", np.concatenate([angles, rng.uniform(size=(60, 3))], axis=1))
    else:
        names = ("COS_TH", "RUSIN_TH_TD", "RUSIN_TH_TD_PD")
        count = MEASURED.index(source) - MEASURED.index("ALTA of one angle") + 1
        path = folder / "paint.alta"
        header = f"#DIM {count} 3\n#PARAM_IN {names[count - 1]}\n#PARAM_OUT RGB_COLOR\n"
        coordinates = rng.uniform(0.1, 0.9, size=(30, count))
        _write_rows(path, header, np.concatenate([coordinates, rng.uniform(size=(30, 3))], axis=1))
    return path


def _write_rows(path: Path, header: str, rows: np.ndarray) -> None:
    path.write_text(header + "\n".join(" ".join(f"{x:.6f}" for x in row) for row in rows) + "\n")
