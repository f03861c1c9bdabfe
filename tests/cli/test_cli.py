"""The command line: what each command makes."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from shrm import brdf
from shrm.cli import COMMANDS, main
from shrm.cli import demonstration as demo
from shrm.cli.options import LAYOUTS
from shrm.environment import Environment, layouts
from shrm.frequency.reflection_map import ReflectionMap
from shrm.image_io import ImageWarning, read_image, write_image
from shrm.integrate import angular, hierarchical
from shrm.integrate.angular import prefilter_angular
from shrm.integrate.hierarchical import prefilter_hierarchical
from shrm.methods import cost
from shrm.prefiltered import Prefiltered
from shrm.version import __version__
from support.data import require

Array = npt.NDArray[np.floating]


Command = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize("command", [module.__name__.rpartition(".")[2] for module in COMMANDS])
def test_help_has_an_example(shrm: Command, command: str) -> None:
    status, out, _ = shrm(command, "--help")
    assert status == 0
    assert f"example: shrm {command}" in out


def test_the_command_is_installed() -> None:
    command = Path(sys.executable).with_name("shrm")
    assert command.exists()
    done = subprocess.run([command, "--help"], capture_output=True, text=True, check=True)
    assert "prefilter" in done.stdout


def test_the_version_is_that_of_the_package(shrm: Command) -> None:
    assert shrm("--version") == (0, f"shrm {__version__}\n", "")


def test_info_tells_of_an_environment(shrm: Command, sky: Path) -> None:
    status, out, err = shrm("info", sky)
    assert (status, err) == (0, "")
    assert "32 x 16" in out
    # The sphere's mean of 1.2 + z + 0.2 x is 1.2.
    mean = next(line for line in out.splitlines() if "mean radiance" in line).split()[2:5]
    np.testing.assert_allclose([float(value) for value in mean], [1.2, 1.2, 1.3], atol=2e-3)
    share = float(next(line for line in out.splitlines() if "energy" in line).split("%")[1].split()[-1])
    assert share > 99.5  # to degree 1; the rest is in the texels' edges


def test_info_tells_of_a_material(shrm: Command) -> None:
    status, out, _ = shrm("info", "--brdf", "lambert:0.5 + ggx:0.3")
    assert status == 0
    assert "lobe 1" in out
    assert "about the normal" in out
    assert "lobe 2" in out


@pytest.mark.parametrize("layout", LAYOUTS)
def test_convert_keeps_the_mean_radiance(shrm: Command, sky: Path, tmp_path: Path, layout: str) -> None:
    cross, back = tmp_path / ("{}.exr" if layout == "faces" else "converted.exr"), tmp_path / "back.exr"
    status, out, _ = shrm("convert", sky, "--layout", layout, "-o", cross)
    assert status == 0
    assert layout in out
    assert shrm("convert", cross, "-o", back)[0] == 0  # the file states its layout
    means = [Environment.read(path).coefficients(0)[0] for path in (sky, back)]
    np.testing.assert_allclose(means[0], means[1], rtol=1e-3)


def test_prefilter_saves_a_map_that_loads(shrm: Command, sky: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.exr"
    status, out, _ = shrm("prefilter", sky, "--brdf", "ggx:0.4", "--orders", "6,2", "-o", path)
    assert status == 0
    assert "F = 6, P = 2" in out
    rm = ReflectionMap.load(path)
    assert (rm.F, rm.P) == (6, 2)


def test_prefilter_reaches_a_tolerance(shrm: Command, sky: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.exr"
    options = ("--tolerance", "0.1", "--layout", "cube", "--size", "16")
    assert shrm("prefilter", sky, "--brdf", "phong:20", *options, "-o", path)[0] == 0
    rm = ReflectionMap.load(path)
    assert rm.error < 0.1
    assert rm.at_view((0.0, 0.0, 1.0)).shape[:2] == (6, 16)


def test_prefilter_takes_its_choices(shrm: Command, sky: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.exr"
    choices = ("--center", "reflection", "--criterion", "brdf", "--window", "hann", "--clamp")
    orders = ("--tolerance", "0.01", "--max-orders", "5,2")
    status, _, err = shrm("prefilter", sky, "--brdf", "ggx:0.3", *choices, *orders, "-o", path)
    assert status == 0
    assert "warning: " in err  # the tolerance is not met within the largest orders
    rm = ReflectionMap.load(path)
    assert rm.F <= 5
    assert rm.P <= 2
    assert [part.center for part in rm.parts] == ["reflection"]
    assert (rm.criterion, rm.window, rm.clamp) == ("brdf", "hann", True)


@pytest.mark.slow
@pytest.mark.parametrize("technique", ["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"])
def test_prefilter_makes_maps_by_earlier_techniques(
    shrm: Command, sky: Path, tmp_path: Path, technique: str
) -> None:
    path, drawn, made = (tmp_path / name for name in ("map.exr", "drawn.exr", "made.exr"))
    material = ("--brdf", "lambert:0.5 + ggx:0.4")
    status, out, _ = shrm("prefilter", sky, *material, "--technique", technique, "-o", path)
    assert status == 0
    assert "Diffuse (n) + " in out
    assert len(Prefiltered.load(path).lobes) == 2
    status, out, _ = shrm("info", path)
    assert status == 0
    assert "prefiltered maps of " in out
    assert "Diffuse (n), about the normal" in out
    row = ("--env", sky, "--size", "24x24", "--samples", 1)
    assert shrm("render", *row, "--map", path, "-o", drawn)[0] == 0
    assert shrm("render", *row, *material, "--technique", technique, "-o", made)[0] == 0
    # The file's error is the tolerance, 5%; that of the other 1%.
    found, expected = (read_image(name).pixels for name in (drawn, made))
    assert np.abs(found - expected).max() < 0.1 * expected.max()
    status, _, err = shrm("prefilter", sky, *material, "--technique", technique, "--clamp", "-o", path)
    assert status == 2
    assert "not allowed with argument --clamp" in err


def test_a_saved_map_draws_the_picture_of_its_material(shrm: Command, sky: Path, tmp_path: Path) -> None:
    saved, pictures = tmp_path / "map.exr", [tmp_path / "material.exr", tmp_path / "map-drawn.exr"]
    orders = ("--orders", "6,2")
    assert shrm("prefilter", sky, "--brdf", "ggx:0.4", *orders, "-o", saved)[0] == 0
    row = ("--env", sky, "--brdf", "lambert:0.5", *orders, "--size", "64x32", "--samples", 1)
    assert shrm("render", *row, "--brdf", "ggx:0.4", "-o", pictures[0])[0] == 0
    assert shrm("render", *row, "--map", saved, "-o", pictures[1])[0] == 0
    made, loaded = (read_image(path).pixels for path in pictures)
    np.testing.assert_array_equal(loaded, made)


@pytest.mark.parametrize("method", ["angular", "hierarchical"])
def test_saved_results_of_integrators_are_described_and_drawn(
    shrm: Command, sky: Path, tmp_path: Path, method: str
) -> None:
    prefilter = {"angular": prefilter_angular, "hierarchical": prefilter_hierarchical}[method]
    material = brdf.parse("lambert:0.5 + ggx:0.4")
    saved, pictures = tmp_path / "result.exr", [tmp_path / "material.exr", tmp_path / "result-drawn.exr"]
    prefilter(Environment.read(sky), material).save(saved)
    status, out, _ = shrm("info", saved)
    assert status == 0
    assert f"{method} integration of {material.name}" in out
    assert "about the normal" in out
    assert "about the lobe" in out
    row = ("--env", sky, "--size", "16x16", "--samples", 1)
    assert (
        shrm("render", *row, "--brdf", "lambert:0.5 + ggx:0.4", "--method", method, "-o", pictures[0])[0] == 0
    )
    assert shrm("render", *row, "--map", saved, "-o", pictures[1])[0] == 0
    made, loaded = (read_image(path).pixels for path in pictures)
    np.testing.assert_array_equal(loaded, made)
    status, _, err = shrm("render", *row, "--map", saved, "--gpu", "-o", pictures[1])
    assert status == 2
    assert "an integrator's result, which only the CPU draws" in err


@pytest.mark.parametrize(
    "choice",
    [
        ("--method", "frequency"),
        ("--method", "angular"),
        ("--method", "hierarchical"),
        ("--method", "auto"),
        ("--technique", "cabral"),
    ],
    ids=lambda choice: choice[1],
)
def test_render_draws_a_row(shrm: Command, sky: Path, tmp_path: Path, choice: tuple[str, str]) -> None:
    path = tmp_path / "row.exr"
    materials = ("--brdf", "lambert:0.5", "--brdf", "phong:9")
    status, out, _ = shrm(
        "render", "--env", sky, *materials, "--size", "96x50", *choice, "--samples", 1, "-o", path
    )
    assert status == 0
    assert "96 x 50, linear" in out
    pixels = read_image(path).pixels
    assert pixels.shape == (50, 96, 3)
    left, right = pixels[:, :48], pixels[:, 48:]
    assert np.abs(left - right).max() > 0.1  # two materials


def test_methods_agree(shrm: Command, sky: Path, tmp_path: Path) -> None:
    pictures = []
    for method in ("frequency", "angular", "hierarchical"):
        path = tmp_path / f"{method}.exr"
        orders = ("--orders", "8,0") if method == "frequency" else ()
        arguments = ("--env", sky, "--brdf", "lambert:0.7", *orders, "--method", method)
        assert shrm("render", *arguments, "--size", "32x32", "--samples", 1, "-o", path)[0] == 0
        pictures.append(read_image(path).pixels)
    # Light of degree 1 on 16 rows, constant over its texels: (pi/16)^2/6 and less, about 0.5%.
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=1e-2)
    np.testing.assert_allclose(pictures[0], pictures[2], rtol=2e-2)


def test_render_writes_png_with_alpha(shrm: Command, sky: Path, tmp_path: Path) -> None:
    from OpenImageIO import FLOAT, ImageBuf

    path = tmp_path / "ball.png"
    arguments = ("--env", sky, "--brdf", "lambert:0.7", "--size", "40x40", "--no-background", "-o", path)
    status, out, _ = shrm("render", *arguments)
    assert status == 0
    assert "exposure" in out
    with_alpha = ImageBuf(str(path)).get_pixels(FLOAT)
    assert with_alpha.shape == (40, 40, 4)
    assert with_alpha[20, 20, 3] == 1.0
    assert with_alpha[0, 0, 3] == 0.0


def test_render_draws_a_mesh_with_a_texture(shrm: Command, sky: Path, tmp_path: Path) -> None:
    mesh, texture = tmp_path / "square.obj", tmp_path / "texture.exr"
    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    mesh.write_text(corners + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
    checks = np.zeros((2, 2, 3), np.float32)
    checks[0, 0], checks[1, 1] = 1.0, 0.5
    write_image(texture, checks)
    path = tmp_path / "square.exr"
    arguments = ("--env", sky, "--brdf", "lambert:1", "--mesh", mesh, "--texture", texture, "--view", "0,0")
    assert shrm("render", *arguments, "--no-background", "--size", "60x60", "-o", path)[0] == 0
    with pytest.warns(ImageWarning, match="alpha"):
        pixels = read_image(path).pixels
    upper_left, upper_right, lower_left, lower_right = (
        float(pixels[row, column, 1])
        for row in (20, 39)
        for column in (20, 39)  # texel centers: half way out
    )
    assert upper_left > 0.1
    assert lower_right == pytest.approx(0.5 * upper_left, rel=0.03)
    assert abs(upper_right) < 0.03 * upper_left
    assert abs(lower_left) < 0.03 * upper_left


@pytest.mark.parametrize("gpu", [[], ["--gpu"]], ids=["cpu", "gpu"])
def test_render_takes_tangents(shrm: Command, sky: Path, tmp_path: Path, gpu: list[str]) -> None:
    mesh = tmp_path / "square.obj"
    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 1\nvt 0 2\nvt -1 1\n"
    mesh.write_text(corners + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")  # u runs aslant
    pictures = {}
    for tangents in ("axis", "uv", "principal"):
        path = tmp_path / f"{tangents}.exr"
        arguments = ("--env", sky, "--brdf", "banks:0.5", "--mesh", mesh, "--tangents", tangents, *gpu)
        assert shrm("render", *arguments, "--size", "40x40", "-o", path)[0] == 0
        pictures[tangents] = read_image(path).pixels
    brightest = pictures["axis"].max()
    np.testing.assert_allclose(pictures["principal"], pictures["axis"], atol=1e-5 * brightest)  # it is flat
    assert np.abs(pictures["uv"] - pictures["axis"]).max() > 0.01 * brightest


@pytest.mark.slow
def test_a_real_map_end_to_end(shrm: Command, tmp_path: Path) -> None:
    source = require("env/debevec_grace_cross.hdr")
    path = tmp_path / "grace.exr"
    assert shrm("prefilter", source, "--brdf", "microfacet:0.3", "-o", path)[0] == 0
    assert ReflectionMap.load(path).error <= 0.05
    picture = tmp_path / "grace.png"
    arguments = ("--env", source, "--brdf", "microfacet:0.3", "--size", "64x64", "-o", picture)
    assert shrm("render", *arguments)[0] == 0
    assert picture.stat().st_size > 1000


@pytest.mark.slow
def test_the_demo_leaves_a_folder(shrm: Command, tmp_path: Path) -> None:
    status, out, _ = shrm("demo", "--size", 12, "-o", tmp_path / "demo")
    assert status == 0
    assert "measured" in out
    assert all(len(line) <= 80 for line in out.splitlines() if str(tmp_path) not in line)
    names = {path.name for path in (tmp_path / "demo").iterdir()}
    assert {"spheres.png", "integrated.png", "difference.png"} <= names
    assert sum(name.endswith(".exr") for name in names) >= 6


class Shaded:
    """A material that is a function of the mirrored view (n, 3) and of N.V (n,)."""

    def __init__(self, light: Callable[[Array, Array], Array]) -> None:
        self.light = light

    def radiance(self, normals: Array, views: Array, tangents: Array | None = None) -> Array:
        cosine = np.sum(normals * views, axis=1)
        shade = self.light(2.0 * cosine[:, None] * normals - views, cosine)
        return np.repeat(shade[:, None], 3, axis=1)


def test_the_demos_measure_is_that_of_the_prediction(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against expectations over R uniform on the sphere and x = cos^2 uniform, known in closed form."""

    def measured(light: Callable[[Array, Array], Array]) -> float:
        one = Shaded(lambda R, cosine: np.ones(len(R)))
        return demo.relative_rms(Shaded(lambda R, cosine: 1.0 + light(R, cosine)), one, about_tangent=False)

    # The cap below varies most. A draw's variance over its mean squared is w E(16 t^6) / (cap / 2), w = .126:
    # 38. So the mean of 40000 deviates by 3%, its root by half of that, and 5% is three deviations.
    monkeypatch.setattr(demo, "FRAMES", 40_000)
    assert measured(lambda R, cosine: cosine**2) == pytest.approx((1 / 3) ** 0.5, rel=0.05)  # E x^2
    assert measured(lambda R, cosine: R[:, 2]) == pytest.approx((1 / 3) ** 0.5, rel=0.05)  # E z^2
    sun = Environment.daylight(sun_elevation=demo.SUN_ELEVATION, sun_azimuth=demo.SUN_AZIMUTH, size=64)
    toward = layouts.directions("latlong", 64, 128)[
        np.unravel_index(sun.pixels.sum(axis=2).argmax(), (64, 128))
    ]
    cap = 1.0 - np.cos(np.radians(10.0))  # of the sphere: cap / 2
    assert measured(lambda R, cosine: R @ toward > 1.0 - cap) == pytest.approx((cap / 2) ** 0.5, rel=0.05)


def test_the_gpu_draws_what_the_cpu_draws(tmp_path):
    pictures = []
    for gpu in ([], ["--gpu"]):
        path = tmp_path / f"{len(gpu)}.exr"
        row = ["--brdf", "ggx:0.4", "--brdf", "lambert:0.8", "--orders", "8,3", "--samples", "2"]
        assert main(["render", *row, *gpu, "--size", "64x32", "-o", str(path)]) == 0
        pictures.append(read_image(path).pixels)
    assert np.linalg.norm(pictures[1] - pictures[0]) < 5e-3 * np.linalg.norm(pictures[0])


@pytest.mark.slow
@pytest.mark.parametrize("gpu", [[], ["--gpu"]], ids=["cpu", "gpu"])
@pytest.mark.parametrize("what", ["light", "camera"])
def test_a_turntable_goes_once_round(tmp_path, capsys, gpu, what):
    size = ["--size", "32x24", "--samples", "1", "--orders", "6,2"]
    frames = ["--turntable", what, "--frames", "4", "-o", str(tmp_path / "spin.exr")]
    assert main(["render", "--brdf", "ggx:0.5", *gpu, *size, *frames]) == 0
    assert "spin-000.exr to spin-003.exr: 32 x 24" in capsys.readouterr().out
    pictures = [read_image(tmp_path / f"spin-00{k}.exr").pixels for k in range(4)]
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"spin-00{k}.exr" for k in range(4)]
    assert all(np.abs(picture - pictures[0]).max() > 0.01 for picture in pictures[1:])
    # A quarter of the way the camera looks where --view of as much has it look; light that has turned by a
    # quarter is what a camera sees that has turned back by as much.
    azimuth = 90 if what == "camera" else -90
    path = tmp_path / "view.exr"
    assert main(["render", "--brdf", "ggx:0.5", *gpu, *size, f"--view={azimuth},10", "-o", str(path)]) == 0
    found = read_image(path).pixels
    assert np.abs(pictures[1] - found).max() < 2e-3 * found.max()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--frames", "3"], "argument --frames: only allowed with argument --turntable"),
        (["--gpu", "--method", "angular"], "argument --gpu: not allowed with argument --method angular"),
        (["--gpu", "--residual", "auto"], "argument --residual: not allowed with argument --gpu"),
        (["--turntable", "--method", "angular"], "argument --turntable light: not allowed with argument"),
        (["--turntable", "--map", "x.exr"], "argument --turntable light: not allowed with argument --map"),
        (["--orders", "3,2", "--technique", "cabral"], "argument --orders: not allowed with argument"),
        (["--max-orders", "3,2", "--orders", "3,2"], "argument --max-orders: not allowed with argument"),
        (["--tolerance", ".1", "--method", "angular"], "argument --tolerance: not allowed with argument"),
        (["--method", "auto", "--technique", "cabral"], "argument --method: not allowed with argument"),
    ],
)
def test_what_does_not_go_together_is_said(arguments, said, capsys, tmp_path):
    with pytest.raises(SystemExit) as stopped:
        main(["render", "--brdf", "ggx:0.5", *arguments, "-o", str(tmp_path / "x.png")])
    assert stopped.value.code == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_cheapest_method_has_the_tolerance_that_it_was_chosen_for(
    shrm: Command, sky: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever it is; without one, that of frequency space."""
    asked: list[object] = []
    for module, name in ((angular, "prefilter_angular"), (hierarchical, "prefilter_hierarchical")):
        function = getattr(module, name)
        monkeypatch.setattr(
            module, name, lambda *of, f=function, **named: asked.append(named["tolerance"]) or f(*of, **named)
        )
    row = ("--env", sky, "--size", "8x8", "--samples", 1, "--brdf", "ggx:0.4", "--method", "auto")
    for method in ("angular", "hierarchical"):
        monkeypatch.setattr(cost, "cheapest", lambda *_, m=method, **of: asked.append(of["tolerance"]) or m)
        for given, tolerance in (((), 0.05), (("--tolerance", "0.2"), 0.2)):
            asked.clear()
            assert shrm("render", *row, *given, "-o", tmp_path / "drawn.exr")[0] == 0
            assert asked == [tolerance, tolerance]
