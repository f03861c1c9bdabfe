"""Say what an environment map, a reflection map or a material holds.

An environment: its size, its range, its mean radiance, and how its energy is spread over the
degrees of spherical harmonics. A reflection map: its material, orders and error. An object with transfer:
its material, what its file keeps and how accurate that is. A material: its lobes, its albedo, the orders
that it needs; if it was measured, how far it is from reciprocal, whether it reflects more than it receives,
and where there are no data. With --plot, a picture of the material: its lobes, its spectrum, what orders
capture of it, and a sphere lit by the environment.
"""

from __future__ import annotations

import argparse
import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.options import (
    DAYLIGHT_AZIMUTH,
    MATERIAL,
    add_environment,
    add_extrapolate,
    material_text,
    parse_brdf,
    read_environment,
)

if TYPE_CHECKING:
    from shrm.brdf import BRDF, Measured
    from shrm.environment import Environment

EXAMPLE = "shrm info grace.hdr    or    shrm info --brdf krylon_blue.brdf --plot krylon.png"

DEGREES = 60  # of the spectrum that are looked at


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(
        command,
        optional=True,
        layout_flags=("--layout", "--env-layout"),
        or_else="; or a file of measurements, a reflection map, an object with transfer",
    )
    command.add_argument("--brdf", metavar="B", help=MATERIAL)
    add_extrapolate(command)
    command.add_argument("--plot", type=picture, metavar="FILE", help="picture of the material, .png")


def picture(text: str) -> Path:
    """Read the name of a picture."""
    if not text.lower().endswith(".png"):
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs a name that ends in .png")
    return Path(text)


def run(options: argparse.Namespace) -> None:
    """Print what is asked for."""
    if options.env is not None and is_measured(options.env):
        if options.brdf is not None:
            raise argparse.ArgumentError(None, f"{options.env} is a material itself: it goes without --brdf")
        options.env, options.brdf = None, options.env
    if options.env is None and options.brdf is None:
        raise argparse.ArgumentError(None, "needs an environment, a file of measurements or --brdf")
    if options.plot is not None and options.brdf is None:
        raise argparse.ArgumentError(None, "argument --plot: is of a material, and needs --brdf")
    env = None
    if options.env is not None and is_reflection_map(options.env):
        print(options.env, *map_lines(options.env), sep="\n")
    elif options.env is not None and is_transfer(options.env):
        print(options.env, *transfer_lines(options.env), sep="\n")
    elif options.env is not None:
        with progress("Reading the environment"):
            env = read_environment(options)
            lines = environment_lines(env)
        print(options.env, *lines, sep="\n")
    if options.brdf is not None:
        brdf = parse_brdf(material_text(options, options.brdf))
        with progress("Looking at the material"):
            lines = material_lines(brdf)
        print(brdf.name, *lines, sep="\n")
        if options.plot is not None:
            plot(options.plot, brdf, env, "daylight" if env is None else Path(options.env).stem)


def is_measured(path: str) -> bool:
    """Whether a file is one of measurements."""
    from shrm.brdf import measured

    try:
        return measured.recognised(Path(path.partition(":sample=")[0])) is not None
    except OSError:
        return False  # reading it as an environment says what is wrong


def plot(path: Path, brdf: BRDF, env: Environment | None, env_name: str) -> None:
    """Write the picture of a material."""
    from shrm.environment import Environment
    from shrm.files import write_bytes
    from shrm.render.material_figure import material_figure

    with progress("Drawing the material"):
        light = Environment.daylight(sun_azimuth=DAYLIGHT_AZIMUTH) if env is None else env
        drawn = io.BytesIO()
        material_figure(brdf, light, env_name).savefig(drawn, format="png", dpi=110)
        write_bytes(path, drawn.getvalue())
    print(path)


def is_reflection_map(path: str) -> bool:
    """Whether a file is one that `shrm prefilter` wrote."""
    from shrm.image_io import ImageError, read_parts

    try:
        return path.endswith(".exr") and any("shrm:version" in part.metadata for part in read_parts(path))
    except ImageError:
        return False  # reading it as an environment says what is wrong


def map_lines(path: str) -> list[str]:
    """What a reflection map holds, a line for each fact."""
    from shrm.frequency.reflection_map import ReflectionMap

    rm = ReflectionMap.load(path)
    lines = [
        f"  reflection map of {rm.brdf}",
        f"  predicted error {rm.error:.2%} ({rm.criterion}), window {rm.window or 'none'}",
    ]
    if rm.residual is not None:
        H, W, _ = rm.residual.pixels.shape
        lines.append(f"  residual {len(rm.residual.cores)} of the lobes have a core, under {W} x {H} texels")
    for index, part in enumerate(rm.parts, start=1):
        lines.append(
            f"  lobe {index}         about the {part.center}, F = {part.F}, P = {part.P}, "
            f"{part.rings.shape[1]} maps, {part.layout} {part.size}"
        )
    return lines


def is_transfer(path: str) -> bool:
    """Whether a file is one that `shrm transfer` wrote."""
    from shrm.render import transferred

    return transferred.is_transfer(path)


def transfer_lines(path: str) -> list[str]:
    """What an object with transfer holds, a line for each fact."""
    from shrm.transfer import RadianceTransfer

    made = RadianceTransfer.load(path)
    snr, path = made.report.get("SNR of matrices"), made.report.get("path", "an unknown path")
    way = "straight from rays" if path == "direct" else f"by way of {path}"
    lines = [
        f"  {len(made.vertices)} vertices, {len(made.faces)} faces",
        f"  material {made.material}, {'grey' if made.channels == 1 else 'RGB'}",
        f"  light    of order {made.n}",
        f"  tents    {made.M} x {made.M}, {way}: " + ("exact" if snr is None else f"{snr:.1f} dB"),
    ]
    for name, variant in made.variants.items():
        said = made.report.get("compression", {}).get(name, {})
        kept = [] if variant.matrices is None else ["matrices"]
        if variant.weights is not None:
            clusters = (
                "" if variant.clusters is None else f" in each of {int(variant.clusters.max()) + 1} clusters"
            )
            snr = said.get("SNR")
            kept.insert(0, f"{variant.K} components{clusters}" + ("" if snr is None else f", {snr:.1f} dB"))
        lines.append(f"  {name:15}{'; '.join(kept)}")
    return lines


def environment_lines(env: Environment) -> list[str]:
    """What an environment holds, a line for each fact."""
    import numpy as np

    H, W = env.pixels.shape[:2]
    luminance = env.pixels.astype(np.float64) @ [0.2126, 0.7152, 0.0722]
    span = f"{luminance.min():.3g} to {luminance.max():.3g}"
    low = np.quantile(luminance, 0.001)  # the darkest texels of photographs are noise
    if low > 0.0:
        span += f", dynamic range {luminance.max() / low:.2g} (from the 0.1% quantile)"

    edges = np.cos(np.arange(H + 1) * np.pi / H)
    areas = (edges[:-1] - edges[1:]) * 2.0 * np.pi / W
    total = float(np.einsum("i,ijc,ijc->", areas, env.pixels, env.pixels, dtype=np.float64))
    coefficients = env.coefficients(min(DEGREES, H // 2 - 1) if H > 3 else 0)
    degree = np.floor(np.sqrt(np.arange(len(coefficients)))).astype(int)
    captured = np.cumsum(np.bincount(degree, weights=np.sum(coefficients**2, axis=1)))
    mean = coefficients[0] / np.sqrt(4.0 * np.pi)
    lines = [
        f"  as lat-long    {W} x {H}",
        f"  luminance      {span}",
        "  mean radiance  " + " ".join(f"{value:.4g}" for value in mean) + "  (R G B)",
    ]
    if total > 0.0:
        shares = [
            f"{captured[F] / total:.1%} to {F}" for F in (0, 1, 2, 4, 8, 16, 30, 60) if len(captured) > F
        ]
        lines.append("  energy         " + ", ".join(shares) + "  (degrees)")
    return lines


def material_lines(brdf: BRDF) -> list[str]:
    """What a material is made of, a line for each fact."""
    import numpy as np

    from shrm.brdf import Material, Measured, directional_albedo
    from shrm.frequency import orders

    measured = measured_lines(brdf) if isinstance(brdf, Measured) else []
    angles = (0, 30, 60, 80)
    with warnings.catch_warnings():  # three digits are shown
        warnings.simplefilter("ignore", RuntimeWarning)
        albedo = directional_albedo(brdf, np.cos(np.radians(angles)))
    lines = [
        *measured,
        "  albedo         "
        + ", ".join(
            " ".join(f"{value:.3g}" for value in values) + f" at {angle}"
            for angle, values in zip(angles, albedo, strict=True)
        )
        + "  (degrees of the view)",
    ]
    for index, lobe in enumerate(brdf.lobes, start=1):
        if lobe.kind == "anisotropic":
            lines.append(f"  lobe {index}         anisotropic: for matrix radiance transfer, no map holds it")
            continue
        with warnings.catch_warnings():  # the line says it
            warnings.simplefilter("ignore", orders.ToleranceWarning)
            found = orders.choose(Material((lobe,), f"lobe {index}"), tolerance=0.03, criterion="brdf")
        limit = "" if not found.limited_by else f", not more within F <= {orders.F_MAX}, P <= {orders.P_MAX}"
        lines.append(
            f"  lobe {index}         about the {lobe.center}, F = {found.F}, P = {found.P}"
            f" for {1.0 - found.error:.1%} of its energy{limit}"
        )
    return lines


def measured_lines(brdf: Measured) -> list[str]:
    """What is to be known of measurements, a line for each fact."""
    import numpy as np

    from shrm.lobes.measurement_quality import quality

    found = quality(brdf)
    largest, view = found.largest_albedo
    filled = {"nearest": "continued (nearest)", "zero": "black"}[brdf.extrapolate]
    return [
        f"  source         {brdf.source}",
        *(f"  note           {note}" for note in brdf.notes),
        f"  reciprocity    f(L, V) and f(V, L) differ by {found.reciprocity_error:.1%} (mean, where both have"
        " data)",
        f"  largest albedo {largest:.3g} of a channel, at {np.degrees(view):.0f} degrees"
        + (": more than it receives" if largest > 1.0 else ""),
        f"  data           for {found.covered:.1%} of all pairs of directions, complete"
        f" to {np.degrees(found.covered_to):.0f} degrees; elsewhere {filled}",
    ]
