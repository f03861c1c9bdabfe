"""The command line: faults in one line, the exit status, and nothing left behind."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from shrm.cli.options import LAYOUTS
from shrm.environment import layouts
from shrm.frequency.orders import F_MAX, P_MAX
from shrm.image_io import read_image, write_image

Array = npt.NDArray[np.floating]


Command = Callable[..., tuple[int, str, str]]


def test_layouts_are_those_of_the_library() -> None:
    assert LAYOUTS == layouts.LAYOUTS


def test_the_largest_orders_in_help_are_those_of_the_library(shrm: Command) -> None:
    _, out, _ = shrm("prefilter", "--help")
    assert f"lead to (default: {F_MAX},{P_MAX})" in " ".join(out.split())


def one_line(err: str) -> str:
    lines = [line for line in err.splitlines() if not line.startswith("shrm: warning: ")]
    assert len(lines) == 1, err
    assert "Traceback" not in err
    return lines[0]


BROKEN = {
    "missing": None,
    "empty": b"",
    "another kind": b"#include <stdio.h>\nint main() {}\n" * 20,
}


@pytest.mark.parametrize("content", BROKEN.values(), ids=BROKEN.keys())
@pytest.mark.parametrize("suffix", [".hdr", ".exr", ".png"])
def test_files_that_are_no_pictures(
    shrm: Command, tmp_path: Path, content: bytes | None, suffix: str
) -> None:
    path, output = tmp_path / f"input{suffix}", tmp_path / "output.exr"
    if content is not None:
        path.write_bytes(content)
    for arguments in (
        ("info", path),
        ("convert", path, "-o", output),
        ("prefilter", path, "--brdf", "lambert:1", "-o", output),
        ("render", "--env", path, "--brdf", "lambert:1", "-o", output),
    ):
        status, _, err = shrm(*arguments)
        assert status == 1
        assert str(path) in one_line(err)
        assert not output.exists()


def test_a_truncated_file(shrm: Command, sky: Path, tmp_path: Path) -> None:
    path = tmp_path / "cut.exr"
    path.write_bytes(sky.read_bytes()[:-300])
    status, _, err = shrm("convert", path, "-o", tmp_path / "output.exr")
    assert status == 1
    assert str(path) in one_line(err)
    assert not (tmp_path / "output.exr").exists()


def test_an_unknown_aspect(shrm: Command, tmp_path: Path) -> None:
    path = tmp_path / "odd.exr"
    write_image(path, np.ones((7, 23, 3), np.float32))
    status, _, err = shrm("info", path)
    assert status == 1
    assert str(path) in one_line(err)


def test_texels_that_are_not_finite(shrm: Command, tmp_path: Path) -> None:
    from OpenImageIO import ROI, ImageBuf, ImageSpec

    path, output = tmp_path / "holes.exr", tmp_path / "output.exr"
    pixels = np.ones((8, 16, 3), np.float32)
    pixels[3, 4] = np.nan
    buffer = ImageBuf(ImageSpec(16, 8, 3, "float"))
    buffer.set_pixels(ROI(), pixels)
    buffer.write(str(path))
    status, _, err = shrm("convert", path, "-o", output)
    assert status == 1
    assert str(path) in one_line(err)
    status, _, err = shrm("convert", path, "--repair", "-o", output)
    assert status == 0
    assert err.startswith("shrm: warning: ")
    assert np.isfinite(read_image(output).pixels).all()


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("no-such-command",),
        ("info",),
        ("info", "SKY", "--env-layout", "round"),
        ("convert", "SKY", "-o", "OUT.png"),
        ("prefilter", "SKY", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1"),
        ("prefilter", "SKY", "--brdf", "velvet:1", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "microfacet:0", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "phong:-1", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "ggx:alpha=2", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "ggx:alpha=shiny", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--tolerance", "0", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--tolerance", "nan", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--tolerance", "small", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--orders", "-1,2", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--orders", "3", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--orders", "3,2", "--tolerance", "0.1", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--size", "0", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--center", "tangent", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--criterion", "taste", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--window", "hamming", "-o", "OUT.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "--max-orders", "9", "-o", "OUT.exr"),
        (
            "prefilter",
            "SKY",
            "--brdf",
            "lambert:1",
            "--max-orders",
            "9,2",
            "--orders",
            "3,2",
            "-o",
            "OUT.exr",
        ),
        ("prefilter", "SKY", "--brdf", "lambert:1", "-o", "OUT.png"),
        ("render", "--env", "SKY", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "-o", "OUT.gif"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--size", "40", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--size", "40x0", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--fov", "180", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--view", "0,91", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--exposure", "inf", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "banks:0.5", "--tangents", "along", "-o", "OUT.png"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--near", "--distant", "-o", "OUT.png"),
    ],
)
def test_wrong_command_lines_are_usage_faults(
    shrm: Command, sky: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    words = [word.replace("SKY", str(sky)).replace("OUT", str(tmp_path / "out")) for word in arguments]
    status, out, err = shrm(*words)
    assert status == 2
    assert "error: " in one_line(err)
    assert out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ("convert", "SKY", "-o", "NOWHERE/out.exr"),
        ("prefilter", "SKY", "--brdf", "lambert:1", "-o", "NOWHERE/out.exr"),
        ("render", "--env", "SKY", "--brdf", "lambert:1", "--size", "8x8", "-o", "NOWHERE/out.png"),
        (
            "render",
            "--env",
            "SKY",
            "--brdf",
            "lambert:1",
            "--mesh",
            "NOWHERE/out.obj",
            "-o",
            "FOLDER/out.png",
        ),
        (
            "render",
            "--env",
            "SKY",
            "--brdf",
            "lambert:1",
            "--texture",
            "NOWHERE/out.png",
            "-o",
            "FOLDER/x.png",
        ),
        ("demo", "--size", "4", "-o", "SKY/out"),
    ],
)
def test_files_that_cannot_be_written_or_read(
    shrm: Command, sky: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    words = [
        word.replace("SKY", str(sky))
        .replace("NOWHERE", str(tmp_path / "no"))
        .replace("FOLDER", str(tmp_path))
        for word in arguments
    ]
    status, _, err = shrm(*words)
    assert status == 1
    assert "out" in one_line(err)
    assert list(tmp_path.iterdir()) == []


def test_a_mesh_without_the_uv_that_tangents_need(shrm: Command, sky: Path, tmp_path: Path) -> None:
    mesh = tmp_path / "bare.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    arguments = ("--env", sky, "--brdf", "banks:0.5", "--mesh", mesh, "--tangents", "uv")
    status, _, err = shrm("render", *arguments, "-o", tmp_path / "out.png")
    assert status == 1
    assert f"{mesh}: no texture coordinates: take axis or principal tangents" in one_line(err)
    assert list(tmp_path.iterdir()) == [mesh]


def test_a_file_that_was_there_survives_a_failure(shrm: Command, sky: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.exr"
    output.write_bytes(b"precious")
    broken = tmp_path / "broken.hdr"
    broken.write_bytes(b"#?RADIANCE\n")
    assert shrm("convert", broken, "-o", output)[0] == 1
    assert output.read_bytes() == b"precious"


def test_a_black_map_is_valid(shrm: Command, tmp_path: Path) -> None:
    path, output = tmp_path / "black.exr", tmp_path / "map.exr"
    write_image(path, np.zeros((8, 16, 3), np.float32))
    assert shrm("info", path)[0] == 0
    assert shrm("prefilter", path, "--brdf", "ggx:0.5", "-o", output)[0] == 0
    picture = tmp_path / "black.png"
    assert shrm("render", "--env", path, "--brdf", "ggx:0.5", "--size", "8x8", "-o", picture)[0] == 0


def test_a_map_that_is_none(shrm: Command, sky: Path, tmp_path: Path) -> None:
    status, _, err = shrm("render", "--map", sky, "-o", tmp_path / "out.png")
    assert status == 1
    assert f"{sky}: no result of prefiltering" in one_line(err)
    assert list(tmp_path.iterdir()) == []
