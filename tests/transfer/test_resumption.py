"""Precomputation in a folder: what was finished is not computed again, and never taken for something else."""

import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer.matrices import vertex_matrices
from shrm.transfer.matrices.product import Route
from shrm.transfer.precompute import precompute
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.rays.occluders import Occluders
from support.precomputed import ALL
from support.transfer_meshes import Mesh, Surface, bumpy

MESH = bumpy(7, subdivisions=3)  # 642 vertices: blocks of 512 and 130
SMALL = {"order": 2, "tents": 3, "directions": 64, "components": 4, "variants": ALL, "matrices": True}


def transferred(mesh: Mesh = MESH, material: Any = None, **options: Any) -> RadianceTransfer:
    """Something small, with two bounces where the object lights itself."""
    small = {**SMALL, "route": Route(), **options}
    if "interreflected" in small["variants"]:
        small.setdefault("bounces", 2)
    return precompute(Surface(*mesh), brdf.Lambert(0.5) if material is None else material, **small)


def arrays_of(held: RadianceTransfer) -> dict[str, np.ndarray]:
    return {
        f"{name}/{what}": np.array(array)
        for name, variant in held.variants.items()
        for what, array in vars(variant).items()
        if array is not None
    }


def same(actual: RadianceTransfer, expected: RadianceTransfer) -> None:
    """Bit by bit."""
    assert actual.report == expected.report
    found, wanted = arrays_of(actual), arrays_of(expected)
    assert found.keys() == wanted.keys()
    for name, array in wanted.items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array, err_msg=name)


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often blocks of vertices cast rays, and are made matrices."""
    counted: Counter[str] = Counter()

    def count(name: str, call: Callable[..., Any], of: Callable[..., bool]) -> Callable[..., Any]:
        def counting(*arguments: Any, **options: Any) -> Any:
            counted[name] += of(*arguments)
            return call(*arguments, **options)

        return counting

    # a sample's vertices cast one by one
    several = count("cast", Occluders.cast, lambda self, these, *rest: these.stop - these.start > 1)
    monkeypatch.setattr(Occluders, "cast", several)
    summed = count("matrices", vertex_matrices.accumulate, lambda *rest: True)
    monkeypatch.setattr(vertex_matrices, "accumulate", summed)
    return counted


class Stops:
    """Ends a computation at every step that it has not seen before."""

    def __init__(self) -> None:
        self.seen: set[tuple[str, int]] = set()

    def __call__(self, what: str, done: int, total: int) -> None:
        assert 0 <= done <= total
        if (what, done) not in self.seen:
            self.seen.add((what, done))
            raise KeyboardInterrupt


@pytest.mark.slow
@pytest.mark.parametrize("route", [Route(), Route(3)], ids=str)
def test_stopped_at_every_step_and_continued_it_is_the_same(tmp_path, counts, route):
    whole, steps = transferred(route=route), dict(counts)
    counts.clear()
    stops, times = Stops(), 0
    while True:
        try:
            held = transferred(route=route, work=tmp_path, progress=stops)
            break
        except KeyboardInterrupt:
            times += 1
    same(held, whole)
    assert dict(counts) == steps
    stages = Counter(what for what, _ in stops.seen)
    assert stages["rays"] == stages["shadowed"] == stages["unshadowed"] == stages["interreflected"] == 3
    assert times > 15


def test_progress_goes_up_to_all_of_it():
    steps: list[tuple[str, int, int]] = []
    transferred(progress=lambda what, done, total: steps.append((what, done, total)))
    last: dict[str, tuple[int, int]] = {}
    for what, done, total in steps:
        assert "\n" not in what
        before = last.get(what, (0, total))
        assert done >= before[0]
        assert total == before[1]
        last[what] = (done, total)
    finished = {what for what, (done, total) in last.items() if done == total}
    assert set(last) - finished <= {"materials"}


def test_a_finished_folder_is_read(tmp_path, counts):
    first = transferred(work=tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    counts.clear()
    same(transferred(work=tmp_path), first)
    assert not counts.total()
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_another_material_takes_the_same_rays(tmp_path, counts):
    first = transferred(work=tmp_path)
    kept = arrays_of(first)
    counts.clear()
    glossy = transferred(material=brdf.GGX(0.5), work=tmp_path)
    assert counts["cast"] == 0
    same(glossy, transferred(material=brdf.GGX(0.5)))
    # and what was mapped from the folder is what it was
    for name, array in arrays_of(first).items():
        np.testing.assert_array_equal(array, kept[name])


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {"tents": 4},
        {"order": 3},
        {"route": Route(3)},
        {"albedo": 0.9},
        {"bounces": 1},
        {"variants": ("shadowed",)},
        {
            "tangents": np.random.default_rng(1).normal(size=MESH[0].shape),
            "variants": ("unshadowed",),
        },
        {"material": [brdf.Lambert(0.5)] * 2, "shares": np.random.default_rng(2).uniform(size=(642, 2))},
    ],
    ids=lambda options: " ".join(options),
)
@pytest.mark.parametrize("route", [Route(), Route(3, m=4)], ids=str)
def test_other_options_in_the_same_folder_are_not_mistaken(tmp_path, route, options):
    transferred(route=route, work=tmp_path)
    options = {"route": route, **options}
    same(transferred(work=tmp_path, **options), transferred(**options))


def but_for_the_first(normals: np.ndarray) -> np.ndarray:
    other = np.roll(normals, 1, axis=1)
    other[0] = normals[0]
    return other


@pytest.mark.parametrize("route", [Route(), Route(3, m=4)], ids=str)
def test_other_normals_in_the_same_folder_are_not_mistaken(tmp_path, route):
    vertices, faces, normals = MESH
    options = {"variants": ("unshadowed",), "route": route}
    transferred(work=tmp_path, **options)
    other = (vertices, faces, but_for_the_first(normals))
    same(transferred(other, work=tmp_path, **options), transferred(other, **options))


def test_another_mesh_is_refused_and_the_first_is_kept(tmp_path, counts):
    vertices, faces, normals = MESH
    first = transferred(work=tmp_path)
    for other in (
        (vertices * 1.5, faces, normals),
        (vertices, faces[:-1], normals),
        bumpy(8, subdivisions=3),
    ):
        with pytest.raises(
            ValueError, match=r"^[^\n]*: holds the visibility of something else \([^\n]*\)[^\n]*$"
        ):
            transferred(other, work=tmp_path)
    counts.clear()
    same(transferred(work=tmp_path), first)
    assert not counts.total()


@pytest.mark.parametrize("route", [Route(), Route(3)], ids=str)
def test_another_mesh_after_its_rays_are_removed_is_not_mistaken(tmp_path, route):
    """As the refusal advises. It has the same frames, and others of its vertices see each other."""
    vertices, faces, normals = MESH
    options = {"variants": ("shadowed",), "route": route}
    transferred(work=tmp_path, **options)
    for folder in (one for one in tmp_path.iterdir() if one.is_dir()):
        shutil.rmtree(folder)
    other = (vertices * np.linspace(1, 3, len(vertices))[:, None], faces, normals)
    same(transferred(other, work=tmp_path, **options), transferred(other, **options))


# ---- Damage


def damage(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def test_damaged_matrices_are_computed_again(tmp_path):
    first = transferred()
    transferred(work=tmp_path)
    files = sorted(path for path in tmp_path.iterdir() if path.suffix == ".npy")
    assert len(files) >= 3
    for path in files:
        damage(path)
        same(transferred(work=tmp_path), first)


@pytest.mark.slow
def test_damaged_rays_are_told(tmp_path):
    transferred(work=tmp_path)
    block = next(tmp_path.rglob("*_00001.npz"))
    content = block.read_bytes()
    other = {"material": brdf.Lambert(0.6), "work": tmp_path}
    for wrong in (content[:-1], content[:100], b""):
        block.write_bytes(wrong)
        with pytest.raises(ValueError, match=r"^[^\n]*00001\.npz: missing, cut short or damaged[^\n]*$"):
            transferred(**other)
    block.write_bytes(content)
    damage(block)
    with pytest.raises(ValueError, match=r"^[^\n]*00001\.npz: missing, cut short or damaged[^\n]*$"):
        transferred(**other)
    block.write_bytes(content)
    same(transferred(**other), transferred(material=brdf.Lambert(0.6)))


def test_rays_of_another_version_are_refused(tmp_path):
    transferred(work=tmp_path)
    state = next(tmp_path.rglob("visibility.json"))
    state.write_text(state.read_text().replace('"version": 1', '"version": 2'))
    with pytest.raises(ValueError, match=r"^[^\n]*something else \(version differ\)[^\n]*$"):
        transferred(work=tmp_path)


def test_a_folder_that_cannot_be_made_is_the_systems_error(tmp_path):
    (tmp_path / "file").write_text("text")
    for place in ("file", "file/below"):
        with pytest.raises(OSError, match="file"):
            transferred(work=tmp_path / place)
    assert (tmp_path / "file").read_text() == "text"


def test_matrices_are_not_to_be_written_to(tmp_path):
    """They are the folder's own, which is read again."""
    held = transferred(work=tmp_path, variants=("shadowed",))
    with pytest.raises(ValueError, match="read-only"):
        held.variants["shadowed"].matrices[0] = 0
