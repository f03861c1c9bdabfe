"""`shrm transfer`: from a mesh file to an object with transfer, and `shrm info` of it."""

import pathlib
import signal
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import trimesh
from shrm import brdf
from shrm.cli.console import interrupts_afterwards
from shrm.image_io import write_image
from shrm.render import Mesh
from shrm.transfer import RadianceTransfer, Route, precompute
from shrm.transfer.variant import VARIANTS

Command = Callable[..., tuple[int, str, str]]
FEW = ("--directions", "128", "--tents", "5", "--route", "direct")
EVERY_VARIANT = [word for name in VARIANTS for word in ("--variant", name)]


@pytest.fixture
def mesh_file(tmp_path: pathlib.Path) -> pathlib.Path:
    """Two spheres that see each other, with texture coordinates: u is 0 on the one and 1 on the other."""
    left, right = trimesh.creation.icosphere(1), trimesh.creation.icosphere(1).apply_translation([2.2, 0, 0])
    both = trimesh.util.concatenate([left, right])
    uv = np.zeros((len(both.vertices), 2)) + 0.5
    uv[: len(left.vertices), 0], uv[len(left.vertices) :, 0] = 0.25, 0.75
    both.visual = trimesh.visual.TextureVisuals(uv=uv)
    path = tmp_path / "spheres.obj"
    both.export(path)
    return path


@pytest.mark.slow
def test_the_command_makes_what_the_library_makes(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    out = tmp_path / "spheres.shrt"
    status, said, err = shrm(
        "transfer",
        mesh_file,
        "--brdf",
        "ashikhmin-shirley:nu=40,nv=10",
        *EVERY_VARIANT,
        "--bounces",
        "2",
        *FEW,
        "-o",
        out,
    )
    assert (status, err) == (0, "")
    assert "5 x 5 tents" in said
    assert not (tmp_path / "spheres.shrt.work").exists()
    found = RadianceTransfer.load(out)
    assert list(found.variants) == ["unshadowed", "shadowed", "interreflected"]
    expected = precompute(
        Mesh.read(mesh_file),
        brdf.AshikhminShirley(40, 10),
        directions=128,
        tents=5,
        route=Route(),
        bounces=2,
        variants=["unshadowed", "shadowed", "interreflected"],
    )
    light = np.random.default_rng(0).normal(size=(25, 3))
    for variant in found.variants:
        np.testing.assert_allclose(
            found.radiance(light, eye=[-3, 1, 1], variant=variant),
            expected.radiance(light, eye=[-3, 1, 1], variant=variant),
            atol=1e-5,
        )
    status, told, _ = shrm("info", out)
    assert status == 0
    assert "ashikhmin-shirley(nu=40,nv=10)" in told
    assert "tents    5 x 5, straight from rays" in told
    assert "interreflected" in told


def test_a_mask_has_the_second_material_where_it_is_white(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    mask, out = tmp_path / "mask.exr", tmp_path / "two.shrt"
    picture = np.zeros((4, 64, 3), np.float32)
    picture[:, 32:] = 1
    write_image(mask, picture)
    command = ("transfer", mesh_file, "--brdf", "lambert:0.2", "--brdf", "lambert:0.8", "--mask", mask)
    assert shrm(*command, "--variant", "unshadowed", *FEW, "-o", out)[0] == 0
    white = np.zeros((25, 3))
    white[0] = np.sqrt(4 * np.pi)
    made = RadianceTransfer.load(out)
    radiance = made.radiance(white, eye=[-9, 0, 0])[:, 0]
    left = made.uv[:, 0] < 0.5
    assert 0 < left.sum() < len(left)
    np.testing.assert_allclose(radiance[left], 0.2, atol=2e-3)
    np.testing.assert_allclose(radiance[~left], 0.8, atol=2e-3)


def test_what_is_kept_is_chosen(shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path) -> None:
    out = tmp_path / "chosen.shrt"
    command = ("transfer", mesh_file, "--brdf", "phong:10", "--directions", "128", "--order", "3")
    options = ("--clusters", "4", "--components", "2", "--tents", "4", "--route", "3,8", "--matrices")
    assert shrm(*command, *options, "--tangents", "uv", "-o", out)[0] == 0
    made = RadianceTransfer.load(out)
    assert (made.n, made.M, made.report["route"]) == (3, 4, "order 3, views of order 8")
    shadowed = made.variants["shadowed"]
    assert shadowed.components.shape == (4, 2, 16, 1, 9)
    assert shadowed.matrices.shape == (len(made.vertices), 16, 1, 9)
    assert "2 components in each of 4 clusters" in shrm("info", out)[1]


def test_a_computation_that_was_stopped_goes_on(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, work = tmp_path / "resumed.shrt", tmp_path / "resumed.shrt.work"
    command = ("transfer", mesh_file, "--brdf", "phong:10", *FEW, "-o", out)

    def stop(*arguments: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr("shrm.transfer.precomputation.Precomputation.compress", stop)
        assert shrm(*command)[0] == 130
    assert not out.exists()
    assert work.is_dir()
    with monkeypatch.context() as patched:
        patched.setattr("shrm.transfer.rays.visibility.Occluders", stop)  # no ray of a vertex is cast again
        assert shrm(*command)[0] == 0
    assert out.exists()
    assert not work.exists()


def test_files_of_others_in_the_work_folder_stay(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    work, scratch = tmp_path / "own.shrt.work", tmp_path / "scratch"
    command = ("transfer", mesh_file, "--brdf", "phong:10", "--matrices", *EVERY_VARIANT, *FEW, "-o")
    work.mkdir()
    (work / "notes.txt").write_text("kept")
    assert shrm(*command, tmp_path / "own.shrt")[0] == 0
    assert [path.name for path in work.iterdir()] == ["notes.txt"]
    scratch.mkdir()
    (tmp_path / "linked.shrt.work").symlink_to(scratch)
    status, _, err = shrm(*command, tmp_path / "linked.shrt")
    assert (status, err) == (0, "")
    assert not list(scratch.iterdir())


def test_an_output_that_is_a_folder_is_refused_before_any_work(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    out = tmp_path / "folder.shrt"
    out.mkdir()
    status, _, err = shrm("transfer", mesh_file, "--brdf", "phong:10", *FEW, "-o", out)
    assert (status, err) == (1, f"shrm: error: {out}: Is a directory\n")
    assert not (tmp_path / "folder.shrt.work").exists()


def test_clusters_are_found_among_fewer_components_than_usual(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    out = tmp_path / "clusters.shrt"
    few = ("--directions", "64", "--tents", "3", "--route", "5", "--clusters", "2")  # 9 tents, 25 harmonics
    status, _, err = shrm("transfer", mesh_file, "--brdf", "lambert:0.5", *few, "-o", out)
    assert (status, err) == (0, "")
    assert RadianceTransfer.load(out).variants["shadowed"].components.shape[:2] == (2, 3)


@pytest.fixture
def interrupts() -> Iterator[None]:
    """SIGINT as of a process in the foreground, whatever this one was started with."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interrupts")
def test_an_interrupt_that_an_import_would_swallow_comes_after_it() -> None:
    done = []

    def careless() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:  # as trimesh does around its imports
            done.append("swallowed")
        done.append("finished")

    with pytest.raises(KeyboardInterrupt), interrupts_afterwards():
        careless()
    assert done == ["finished"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with interrupts_afterwards():
        pass
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # as of a process in the background
    with interrupts_afterwards():
        signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--brdf", "phong:10", "--mask", "no.png"), "--mask"),
        (("--brdf", "phong:10", "--albedo", "0.5"), "--albedo"),
        (("--brdf", "phong:10", "--brdf", "phong:20"), "--mask"),
        (("--brdf", "phong:10", "--route", "8,8,8"), "direct, published, S or S,M"),
        (
            ("--brdf", "phong:10", "--bounces", "1"),
            "--bounces: only allowed with argument --variant interreflected",
        ),
        (("--brdf", "phong"), "--brdf"),
        (("--brdf", "phong:10", "--tents", "1"), "--tents"),
        (("--brdf", "phong:10", "-o", "object.exr"), ".shrt"),
    ],
)
def test_a_wrong_command_line_is_one_line(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path, arguments: tuple[str, ...], said: str
) -> None:
    status, _, err = shrm("transfer", mesh_file, "-o", tmp_path / "x.shrt", *arguments)
    assert status == 2
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--accuracy", "100"), "accuracy"),
        (("--order", "11"), "order must be"),
        (("--directions", "3"), "directions"),
        (("--albedo", "2", "--variant", "interreflected", "--directions", "64", "--tents", "3"), "albedo"),
    ],
)
def test_values_out_of_range_are_one_line(
    shrm: Command, mesh_file: pathlib.Path, tmp_path: pathlib.Path, arguments: tuple[str, ...], said: str
) -> None:
    status, _, err = shrm("transfer", mesh_file, "--brdf", "phong:10", *arguments, "-o", tmp_path / "x.shrt")
    assert status == 1
    assert err.startswith("shrm: error: ")
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "x.shrt").exists()
