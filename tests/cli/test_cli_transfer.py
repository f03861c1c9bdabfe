"""Objects with transfer by the commands: pictures, what a window begins with, faults in one line."""

import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shrm import Environment
from shrm.cli import parser, view
from shrm.image_io import ImageWarning, read_image, write_image
from shrm.render import Object, TransferredMesh, about_vertical, render, row_camera
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.viewer.window.orbit import Orbit
from shrm.viewer.window.state import State
from support.transfer_objects import COMPONENTS, M, N, broken, transferred

SIZE = 48

Command = Callable[..., tuple[int, str, str]]

# ---- Pictures


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "globe.shrt"
    transferred().save(path)
    return path


def drawn(shrm: Command, folder: Path, *arguments: object) -> np.ndarray:
    path = folder / "picture.exr"
    size = ("--size", f"{SIZE}x{SIZE}", "--samples", 1)
    status, out, err = shrm("render", *arguments, *size, "-o", path)
    assert (status, err) == (0, "")
    assert f"{SIZE} x {SIZE}" in out
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImageWarning)  # without a background there is an alpha channel
        return read_image(path).pixels


def test_the_command_draws_what_the_library_does(shrm, sky, file, tmp_path):
    env, thing = Environment.read(sky), TransferredMesh.placed(RadianceTransfer.load(file), turn=20.0)
    camera, _ = row_camera(1, 1.0, 35.0, -10.0)
    for variant, K, tents, window, viewer in (
        (None, None, None, None, "near"),
        ("unshadowed", 12, 3, "hann", "near"),
        ("shadowed", None, None, "lanczos", "distant"),
    ):
        light = thing.light(env.coefficients(N - 1), about_vertical(70.0), window)
        lit = thing.lit(thing.transfer.lighting(variant, components=K, tents=tents), light, camera, viewer)
        expected = render([Object(thing.mesh, lit)], camera, (SIZE, SIZE), samples=1, viewer=viewer)
        chosen = {"--variant": variant, "--components": K, "--tents": tents, "--window": window}
        given = [part for item in chosen.items() if item[1] is not None for part in item]
        where = "--turn", 20, "--light-turn", 70, "--view=35,-10", f"--{viewer}", "--no-background"
        found = drawn(shrm, tmp_path, file, "--env", sky, *given, *where)
        np.testing.assert_array_equal(found, expected.radiance)


def test_zoom_enlarges_the_middle(shrm, sky, file, tmp_path):
    arguments = (file, "--env", sky, "--no-background")
    once, twice = drawn(shrm, tmp_path, *arguments), drawn(shrm, tmp_path, *arguments, "--zoom", 2)
    middle = SIZE // 2
    np.testing.assert_allclose(
        twice[middle - 8 : middle + 8 : 4, middle - 8 : middle + 8 : 4].mean(),
        once[middle - 4 : middle + 4 : 2, middle - 4 : middle + 4 : 2].mean(),
        rtol=0.05,  # half a pixel apart
    )
    seen = [(picture.max(axis=2) > 0).sum() for picture in (once, twice)]
    assert seen[1] > 2 * seen[0]


def test_the_gpu_draws_the_same(shrm, sky, file, tmp_path):
    arguments = (file, "--env", sky, "--light-turn", 50, "--no-background")
    cpu, gpu = drawn(shrm, tmp_path, *arguments), drawn(shrm, tmp_path, *arguments, "--gpu")
    both = (cpu.max(axis=2) > 0) & (gpu.max(axis=2) > 0)
    assert both.sum() > 0.95 * (cpu.max(axis=2) > 0).sum()
    np.testing.assert_allclose(gpu[both], cpu[both], atol=1e-4 * cpu.max())


def test_light_is_turned_once_or_on_a_turntable(shrm, sky, file, tmp_path):
    once = drawn(shrm, tmp_path, file, "--env", sky, "--light-turn", 90)
    arguments = (file, "--env", sky, "--size", f"{SIZE}x{SIZE}", "--samples", 1)
    for kind in ("light", "camera"):
        path = tmp_path / f"{kind}.exr"
        status, _, err = shrm("render", *arguments, "--turntable", kind, "--frames", 4, "-o", path)
        assert (status, err) == (0, "")
    frame = read_image(tmp_path / "light-001.exr").pixels
    np.testing.assert_array_equal(frame, once)
    # The globe is round: to turn the light one way is to walk round it the other way, but for its facets.
    walked = read_image(tmp_path / "camera-003.exr").pixels
    assert np.abs(walked - once).mean() < 0.01 * once.mean()


def test_a_texture_needs_texture_coordinates(shrm, sky, file, tmp_path):
    write_image(tmp_path / "half.exr", np.full((2, 2, 3), 0.5, np.float32))
    textured = "--env", sky, "--no-background", "--texture", tmp_path / "half.exr"
    half = drawn(shrm, tmp_path, file, *textured)
    np.testing.assert_allclose(half, 0.5 * drawn(shrm, tmp_path, file, *textured[:3]), rtol=1e-6)
    replace(transferred(), uv=None).save(tmp_path / "bare.shrt")
    status, out, err = shrm("render", tmp_path / "bare.shrt", *textured, "-o", tmp_path / "x.png")
    assert (status, out) == (1, "")
    assert "bare.shrt" in one_line(err)


# ---- Windows


def begun(*arguments: object) -> State:
    return view.state(parser().parse_args(["view", *map(str, arguments)]))


def test_a_window_begins_with_an_object(file, sky, tmp_path):
    assert begun(file) == State(transfer=str(file))
    chosen = "--variant", "shadowed", "--components", 7, "--tents", 3, "--window", "hann", "--near"
    assert begun(file, "--env", sky, *chosen) == State(
        environment=str(sky),
        transfer=str(file),
        variant="shadowed",
        components=7,
        tents=3,
        window="hann",
        viewer="near",
    )
    renamed = file.rename(tmp_path / "globe.bin")  # its first bytes say what it is
    assert begun(renamed).transfer == str(renamed)


def test_a_saved_window_goes_on_with_its_object_or_others(file, tmp_path):
    saved = State(transfer=str(file), components=7, eye=Orbit(30.0))
    saved.save(tmp_path / "state.json")
    state = "--state", tmp_path / "state.json"
    assert begun(*state) == saved
    assert begun(*state, "--components", 9) == replace(saved, components=9)
    assert begun(*state, "--brdf", "phong:8").transfer is None
    assert begun(file, *state).eye is None


# ---- Faults


def one_line(err: str) -> str:
    (line,) = err.splitlines()
    assert "Traceback" not in line
    return line


OF_MATERIALS = [
    ("--brdf", "ggx:0.3"),
    ("--mesh", "bunny.ply"),
    ("--up", "z"),
    ("--tangents", "uv"),
    ("--tolerance", "0.1"),
    ("--orders", "3,2"),
]
OUT_OF_RANGE = [
    ("--components", "0"),
    ("--components", str(COMPONENTS + 1)),
    ("--components", "many"),
    ("--tents", "1"),
    ("--tents", str(M + 1)),
    ("--variant", "dark"),
    ("--window", "hamming"),
]


@pytest.mark.parametrize(
    "arguments",
    [
        *OF_MATERIALS,
        *OUT_OF_RANGE,
        ("--map", "map.exr"),
        ("--method", "angular"),
        ("--technique", "cabral"),
        ("--frames", "3"),
    ],
    ids="".join,
)
def test_what_an_object_cannot_have_is_refused_for_a_picture(shrm, file, tmp_path, arguments):
    status, out, err = shrm("render", file, *arguments, "-o", tmp_path / "x.png")
    assert (status, out) == (2, "")
    assert one_line(err)
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize(
    "arguments", [*OF_MATERIALS, *OUT_OF_RANGE, ("--technique", "cabral"), ("--filter", "exact")], ids="".join
)
def test_what_an_object_cannot_have_is_refused_for_a_window(shrm, file, arguments):
    status, out, err = shrm("view", file, *arguments)
    assert (status, out) == (2, "")
    assert one_line(err)


def test_a_variant_that_is_not_there_is_refused(shrm, tmp_path):
    transferred(variants=("shadowed",)).save(tmp_path / "one.shrt")
    for command in (("view",), ("render", "-o", tmp_path / "x.png")):
        status, out, err = shrm(*command, tmp_path / "one.shrt", "--variant", "unshadowed")
        assert (status, out) == (2, "")
        assert "one.shrt" in one_line(err)


@pytest.mark.parametrize(
    "arguments",
    [
        ("--variant", "shadowed"),
        ("--components", 3),
        ("--tents", 3),
        ("--window", "hann"),
        ("--light-turn", 3),
    ],
    ids=lambda arguments: arguments[0],
)
def test_options_of_transfer_need_an_object_with_it(shrm, tmp_path, arguments):
    status, _, err = shrm("render", "--brdf", "ggx:0.5", *arguments, "-o", tmp_path / "x.png")
    assert status == 2
    assert f"argument {arguments[0]}: only allowed with argument FILE.shrt" in one_line(err)
    if arguments[0] != "--light-turn":
        status, _, err = shrm("view", "--brdf", "ggx:0.5", *arguments)
        assert status == 2
        assert f"argument {arguments[0]}: only allowed with argument FILE.shrt" in one_line(err)


@pytest.mark.parametrize("how", ["missing", *broken(bytes(2000))])
def test_a_broken_object_is_said_in_one_line(shrm, file, tmp_path, how):
    path = tmp_path / "broken.shrt"
    if how != "missing":
        path.write_bytes(broken(file.read_bytes())[how])
    for command in (("view",), ("render", "-o", tmp_path / "x.png")):
        status, out, err = shrm(*command, path)
        assert (status, out) == (1, "")
        assert "broken.shrt" in one_line(err)
        if how == "of another version":
            assert "version 2, this reads version 1" in err
        assert not (tmp_path / "x.png").exists()


def test_light_that_is_not_there_is_said_in_one_line(shrm, file, tmp_path):
    status, out, err = shrm("render", file, "--env", tmp_path / "missing.hdr", "-o", tmp_path / "x.png")
    assert (status, out) == (1, "")
    assert "missing.hdr" in one_line(err)


def test_two_lights_are_one_too_many(shrm, sky):
    status, _, err = shrm("view", sky, "--env", sky)
    assert status == 2
    assert "argument --env: not allowed with argument ENV" in one_line(err)
