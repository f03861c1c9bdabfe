"""Lines that `shrm info` prints of environments, materials, maps and objects with transfer."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shrm.brdf import BRDF, Measured
    from shrm.environment import Environment
    from shrm.frequency.reflection_map import ReflectionMap
    from shrm.integrate.angular import AngularReflection
    from shrm.integrate.hierarchical import HierarchicalReflection
    from shrm.prefiltered import Prefiltered
    from shrm.result_files import Result
    from shrm.transfer.radiance_transfer import RadianceTransfer

LAST_DEGREE = 60
"""Largest degree of the spectrum of an environment that is computed."""

SHOWN_DEGREES = (0, 1, 2, 4, 8, 16, 30, 60)
"""Degrees up to which the share of an environment's energy is printed."""

VIEW_ANGLES = (0, 30, 60, 80)
"""Angles from the normal, degrees, at which a material's albedo is printed."""

CAPTURED = 0.97
"""Share of a lobe's energy for which orders are printed."""


def environment_lines(env: Environment) -> list[str]:
    """Describe an environment: size, range, mean radiance, energy by degree."""
    import numpy as np

    H, W = env.pixels.shape[:2]
    mean = env.coefficients(0)[0] / np.sqrt(4.0 * np.pi)
    lines = [
        f"  as lat-long    {W} x {H}",
        f"  luminance      {_luminance_range(env)}",
        "  mean radiance  " + " ".join(f"{value:.4g}" for value in mean) + "  (R G B)",
    ]
    shares = _energy_shares(env)
    if shares:
        lines.append(
            "  energy         " + ", ".join(f"{share:.1%} to {F}" for F, share in shares) + "  (degrees)"
        )
    return lines


def _luminance_range(env: Environment) -> str:
    """Return the least and the largest luminance, and their ratio as far as it is no noise."""
    import numpy as np

    from shrm.render.tonemap import LUMINANCE

    luminance = env.pixels.astype(np.float64) @ LUMINANCE
    text = f"{luminance.min():.3g} to {luminance.max():.3g}"
    low = np.quantile(luminance, 0.001)  # the darkest texels of photographs are noise
    if low > 0.0:
        text += f", dynamic range {luminance.max() / low:.2g} (from the 0.1% quantile)"
    return text


def _energy_shares(env: Environment) -> list[tuple[int, float]]:
    """Return degrees and the share of the energy up to each; empty if the environment is black."""
    import numpy as np

    # The energy of all degrees is the integral of the squared radiance.
    H, W = env.pixels.shape[:2]
    edges = np.cos(np.arange(H + 1) * np.pi / H)
    areas = (edges[:-1] - edges[1:]) * 2.0 * np.pi / W
    total = float(np.einsum("i,ijc,ijc->", areas, env.pixels, env.pixels, dtype=np.float64))
    if total <= 0.0:
        return []

    coefficients = env.coefficients(min(LAST_DEGREE, H // 2 - 1) if H > 3 else 0)
    degree = np.floor(np.sqrt(np.arange(len(coefficients)))).astype(int)
    captured = np.cumsum(np.bincount(degree, weights=np.sum(coefficients**2, axis=1)))
    return [(F, float(captured[F]) / total) for F in SHOWN_DEGREES if len(captured) > F]


def material_lines(brdf: BRDF) -> list[str]:
    """Describe a material: its measurements, if it was measured, its albedo and its lobes."""
    from shrm.brdf import Measured

    lines = _measurement_lines(brdf) if isinstance(brdf, Measured) else []
    lines.append(f"  albedo         {_albedos(brdf)}  (degrees of the view)")
    for index, lobe in enumerate(brdf.lobes, start=1):
        lines.append(f"  lobe {index}         {_lobe_description(lobe, index)}")
    return lines


def _albedos(brdf: BRDF) -> str:
    """Return the directional albedo at some angles of the view."""
    import numpy as np

    from shrm.brdf import directional_albedo

    with warnings.catch_warnings():  # about its accuracy, of which three digits are always there
        warnings.simplefilter("ignore", RuntimeWarning)
        albedos = directional_albedo(brdf, np.cos(np.radians(VIEW_ANGLES)))
    return ", ".join(
        " ".join(f"{value:.3g}" for value in albedo) + f" at {angle}"
        for angle, albedo in zip(VIEW_ANGLES, albedos, strict=True)
    )


def _lobe_description(lobe: Any, index: int) -> str:
    """Return the center of a lobe and the orders that it needs."""
    from shrm.brdf import Material
    from shrm.frequency import orders

    if lobe.kind == "anisotropic":
        return "anisotropic: for `shrm transfer` only, no reflection map can hold it"
    with warnings.catch_warnings():  # the line itself says that more is not to be had
        warnings.simplefilter("ignore", orders.ToleranceWarning)
        material = Material((lobe,), f"lobe {index}")
        chosen = orders.choose(None, material, tolerance=1.0 - CAPTURED, criterion="brdf")
    limit = f", not more within F <= {orders.F_MAX}, P <= {orders.P_MAX}" if chosen.limited_by else ""
    return (
        f"about the {lobe.center}, F = {chosen.F}, P = {chosen.P}"
        f" for {1.0 - chosen.error:.1%} of its energy{limit}"
    )


def _measurement_lines(brdf: Measured) -> list[str]:
    """Describe the quality of measurements."""
    import numpy as np

    from shrm.lobes.measurement_quality import quality

    measured = quality(brdf)
    largest, view = measured.largest_albedo
    excess = ": more than it receives" if largest > 1.0 else ""
    filled = {"nearest": "extrapolated (nearest)", "zero": "black"}[brdf.extrapolate]
    return [
        f"  source         {brdf.source}",
        *(f"  note           {note}" for note in brdf.notes),
        f"  reciprocity    f(L, V) and f(V, L) differ by {measured.reciprocity_error:.1%}"
        " (mean, where both have data)",
        f"  largest albedo {largest:.3g} of a channel, at {np.degrees(view):.0f} degrees{excess}",
        f"  data           for {measured.covered:.1%} of all pairs of directions, complete"
        f" to {np.degrees(measured.covered_to):.0f} degrees; elsewhere {filled}",
    ]


def result_lines(result: Result) -> list[str]:
    """Describe a result of prefiltering."""
    from shrm.frequency.reflection_map import ReflectionMap
    from shrm.prefiltered import Prefiltered

    if isinstance(result, ReflectionMap):
        return _reflection_map_lines(result)
    if isinstance(result, Prefiltered):
        return _prefiltered_lines(result)
    return _integrated_lines(result)


def _reflection_map_lines(rm: ReflectionMap) -> list[str]:
    """Describe a reflection map."""
    lines = [
        f"  reflection map of {rm.brdf}",
        f"  predicted error {rm.error:.2%} ({rm.criterion}), window {rm.window or 'none'}",
    ]
    if rm.residual is not None:
        H, W, _ = rm.residual.light.pixels.shape
        lines.append(f"  residual {len(rm.residual.cores)} of the lobes have a core, under {W} x {H} texels")
    for index, part in enumerate(rm.parts, start=1):
        lines.append(
            f"  lobe {index}         about the {part.center}, F = {part.F}, P = {part.P}, "
            f"{part.rings.shape[1]} maps, {part.layout} {part.size}"
        )
    return lines


def _prefiltered_lines(maps: Prefiltered) -> list[str]:
    """Describe the maps of earlier techniques."""
    lines = [f"  prefiltered maps of {maps.brdf}"]
    for index, lobe in enumerate(maps.lobes, start=1):
        lines.append(
            f"  lobe {index}         {type(lobe).__name__} {lobe.keeps}, about the {lobe.center},"
            f" {len(lobe.layers)} maps, {lobe.layout} {lobe.size}"
        )
    return lines


def _integrated_lines(result: AngularReflection | HierarchicalReflection) -> list[str]:
    """Describe what an integrator prepared."""
    from shrm.integrate.angular import AngularReflection

    method = "angular" if isinstance(result, AngularReflection) else "hierarchical"
    return [
        f"  {method} integration of {result.brdf}",
        f"  predicted error {result.error:.2%}",
        *(
            f"  lobe {index}         about the {center}, {result.layout} {result.size}"
            for index, center in enumerate(result.centers, start=1)
        ),
    ]


def transfer_lines(path: str) -> list[str]:
    """Describe the object with transfer in a file."""
    from shrm.transfer import RadianceTransfer

    transfer = RadianceTransfer.load(path)
    snr = transfer.report.get("SNR of matrices")
    accuracy = "exact" if snr is None else f"{snr:.1f} dB"
    route = transfer.report.get("route", "an unknown route")
    from_rays = "straight from rays" if route == "direct" else f"by way of {route}"
    lines = [
        f"  {len(transfer.vertices)} vertices, {len(transfer.faces)} faces",
        f"  material {transfer.material}, {'gray' if transfer.channels == 1 else 'RGB'}",
        f"  light    of order {transfer.n}",
        f"  tents    {transfer.M} x {transfer.M}, {from_rays}: {accuracy}",
    ]
    return lines + [f"  {name:15}{_variant_description(transfer, name)}" for name in transfer.variants]


def _variant_description(transfer: RadianceTransfer, name: str) -> str:
    """Describe the components and matrices of a variant."""
    variant = transfer.variants[name]
    contents = []
    if variant.weights is not None:
        snr = transfer.report.get("compression", {}).get(name, {}).get("SNR")
        components = f"{variant.K} components"
        if variant.clusters is not None:
            components += f" in each of {int(variant.clusters.max()) + 1} clusters"
        contents.append(components if snr is None else f"{components}, {snr:.1f} dB")
    if variant.matrices is not None:
        contents.append("matrices")
    return "; ".join(contents)
