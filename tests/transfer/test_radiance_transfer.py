"""Objects with transfer: what does not fit is refused by name, and saving loses nothing."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pytest
from shrm.transfer import file
from shrm.transfer.file import TransferFileError
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.variant import Variant
from support.transfer_contents import SHAPE, K, M, N, Q, V, random, transfer


def varied(**change: Any) -> Callable[[], RadianceTransfer]:
    """An object whose only variant is of components, one of its arrays changed."""
    arrays: dict[str, Any] = {
        "weights": random(6, V, K),
        "components": random(7, Q, K, *SHAPE),
        "clusters": np.array([0, 1, 1, 0, 1, 0, 0], np.int32),
    }
    return lambda: transfer(variants={"shadowed": Variant(**{**arrays, **change})})


def changed(**change: Any) -> Callable[[], RadianceTransfer]:
    return lambda: transfer(**change)


def with_nan(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.flat[-1] = np.nan
    return array


FRAMES = np.tile(np.eye(3, dtype=np.float32), (V, 1, 1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (changed(n=0), r"n must be in \[1, 10\], got 0"),
        (changed(n=2.0), "n must be a whole number"),
        (changed(n=3), "unshadowed: matrices must have the shape"),
        (changed(M=34), r"M must be in \[2, 33\], got 34"),
        (changed(M=3), "unshadowed: matrices must have the shape"),
        (changed(channels=2), "channels must be 1 or 3, got 2"),
        (changed(channels=3.0), "channels must be a whole number"),
        (changed(channels=True), "channels must be a whole number"),
        (changed(vertices=np.zeros((V, 2))), r"vertices must have the shape \(V, 3\)"),
        (changed(vertices=with_nan(random(0, V, 3))), "vertices must be finite"),
        (changed(vertices=np.zeros((0, 3))), "vertices must have the shape"),
        (changed(vertices=np.zeros((V, 3), complex)), "vertices must be an array of real numbers"),
        (changed(faces=np.zeros((0, 3), int)), "faces must have the shape"),
        (changed(faces=np.zeros((5, 3))), "faces must be an array of whole numbers"),
        (changed(faces=np.full((5, 3), V)), r"faces must be in \[0, 7\), got 15 that are not, from 7 to 7"),
        (
            changed(faces=np.full((5, 3), -1)),
            r"faces must be in \[0, 7\), got 15 that are not, from -1 to -1",
        ),
        (changed(frames=FRAMES[:-1]), "frames must have the shape"),
        (changed(frames=1.01 * FRAMES), "frames must be rotations"),
        (changed(frames=FRAMES * np.array([1, 1, -1])), "frames must be rotations"),
        (changed(frames=with_nan(FRAMES)), "frames must be finite"),
        (changed(uv=np.zeros((V, 3))), "uv must have the shape"),
        (changed(uv=with_nan(np.zeros((V, 2)))), "uv must be finite"),
        (changed(material=None), "material must be a string, got None"),
        (changed(report=[]), "report must be a dict, got list"),
        (changed(variants={}), "variants must hold at least one, got none"),
        (
            changed(variants={"lit": Variant()}),
            "variants must be one of unshadowed, shadowed, interreflected",
        ),
        (changed(variants={"shadowed": Variant()}), "shadowed must have weights and components, or matrices"),
        (varied(components=None), "shadowed must have weights and components"),
        (varied(weights=None), "shadowed must have weights and components"),
        (varied(weights=random(6, V - 1, K)), r"shadowed: weights must have the shape \(7, K\)"),
        (varied(weights=random(6, V, K, dtype=np.float64)), "shadowed: weights must be an array of float32"),
        (varied(weights=with_nan(random(6, V, K))), "shadowed: weights must be finite"),
        (varied(weights=[[1.0] * K] * V), "shadowed: weights must be an array of float32"),
        (varied(components=random(7, K, *SHAPE)), "shadowed: components must have the shape"),
        (varied(components=random(7, Q, K + 1, *SHAPE)), "shadowed: components must have the shape"),
        (varied(components=with_nan(random(7, Q, K, *SHAPE))), "shadowed: components must be finite"),
        (varied(clusters=None), "shadowed: components must have the shape"),
        (varied(clusters=np.zeros(V)), "shadowed: clusters must be an array of whole numbers"),
        (
            varied(clusters=np.full(V, Q)),
            r"shadowed: clusters must be in \[0, 2\), got 7 that are not, from 2 to 2",
        ),
        (varied(clusters=np.full(V, -1)), r"shadowed: clusters must be in \[0, 2\)"),
        (varied(clusters=np.zeros(V + 1, int)), "shadowed: clusters must have the shape"),
    ],
)
def test_what_does_not_fit_is_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}[^\n]*$"):
        make()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"components": 0}, r"components must be in \[1, 3\], got 0"),
        ({"components": K + 1}, r"components must be in \[1, 3\], got 4"),
        ({"components": 2.0}, "components must be a whole number"),
        ({"tents": 1}, r"tents must be in \[2, 2\], got 1"),
        ({"tents": M + 1}, r"tents must be in \[2, 2\], got 3"),
        ({"variant": "lit"}, "variant must be one of unshadowed, shadowed, interreflected, got 'lit'"),
        (
            {"variant": "unshadowed", "components": 1},
            "variant must be compressed where components or tents are given, got unshadowed",
        ),
        ({"light": np.zeros((N * N + 1, 3))}, r"light must have the shape \(4, 3\)"),
        ({"light": np.zeros((N * N, 1))}, r"light must have the shape \(4, 3\)"),
        ({"light": np.full((N * N, 3), np.nan)}, "light must be finite"),
        ({"eye": [0, 0]}, r"eye must have the shape \(3,\)"),
        ({"view": [0, 0, 1]}, "eye or view must be given, got both"),
        ({"eye": None}, "eye or view must be given, got neither"),
        ({"eye": None, "view": [0, 0, 2]}, "view must be unit vectors"),
    ],
)
def test_radiance_of_what_is_not_there_is_refused(options, message):
    given = {"light": np.zeros((N * N, 3)), "eye": [3, 4, 5], **options}
    with pytest.raises((TypeError, ValueError), match=f"^{message}[^\n]*$"):
        transfer().radiance(**given)


def test_fewer_components_are_the_first_and_change_back():
    held, light = varied()(), random(13, N * N, 3)
    whole = held.variants["shadowed"]
    for k in (1, K, 2):
        first = Variant(whole.weights[:, :k].copy(), whole.components[:, :k].copy(), whole.clusters)
        expected = transfer(variants={"shadowed": first}).radiance(light, eye=[3, 4, 5])
        actual = held.radiance(light, eye=[3, 4, 5], components=k)
        np.testing.assert_allclose(actual, expected, atol=1e-6 * np.abs(expected).max())


# ---- Saving


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("fault", [KeyboardInterrupt, ValueError, OSError])
def test_a_save_that_fails_leaves_what_was_there(tmp_path, monkeypatch, fault):
    path = tmp_path / "a.shrt"
    transfer().save(path)
    before = path.read_bytes()
    written = []

    def write_two_arrays(stream: BinaryIO, array: np.ndarray) -> int:
        written.append(array)
        stream.write(array.tobytes())
        if len(written) == 2:
            raise fault("stopped")
        return 0

    monkeypatch.setattr(file, "_write_array", write_two_arrays)
    with pytest.raises((KeyboardInterrupt, ValueError), match="stopped"):
        transfer().save(path)
    assert path.read_bytes() == before
    assert names(tmp_path) == {"a.shrt"}


@pytest.mark.parametrize("value", [np.nan, {1, 2}, b"text", np.float32(1)])
def test_a_report_that_json_does_not_know_is_refused(tmp_path, value):
    with pytest.raises(ValueError, match=r"^report must hold text, finite numbers, lists and dicts [^\n]*$"):
        transfer(report={"value": value}).save(tmp_path / "a.shrt")
    assert not names(tmp_path)


def test_places_that_cannot_be_written_are_told(tmp_path):
    (tmp_path / "folder").mkdir()
    for place in ("folder", "none/a.shrt", 250 * "a" + ".shrt"):
        with pytest.raises(TransferFileError, match=r"^[^\n]*: cannot be written \([^\n]*\)$"):
            transfer().save(tmp_path / place)
    assert names(tmp_path) == {"folder"}
    assert not names(tmp_path / "folder")


def test_a_file_can_be_written_over_while_it_is_mapped(tmp_path):
    path = tmp_path / "a.shrt"
    transfer().save(path)
    found = RadianceTransfer.load(path)
    before = found.variants["interreflected"].matrices.copy()
    transfer(variants={"shadowed": Variant(random(4, V, K), random(5, K, *SHAPE))}).save(path)
    np.testing.assert_array_equal(found.variants["interreflected"].matrices, before)
    assert list(RadianceTransfer.load(path).variants) == ["shadowed"]
    found.save(path)
    np.testing.assert_array_equal(RadianceTransfer.load(path).variants["interreflected"].matrices, before)


# ---- Fewer tents


def hats(M: int, x: np.ndarray) -> np.ndarray:
    """The tents of one dimension at places x in [0, 1], (M, x)."""
    return np.maximum(0, 1 - np.abs(x * (M - 1) - np.arange(M)[:, None]))


def projection(fine: int, coarse: int) -> np.ndarray:
    """Of expansions in fine^2 tents on coarse^2, orthogonally: by Gauss in the pieces of both."""
    ends = np.unique(np.r_[np.linspace(0, 1, fine), np.linspace(0, 1, coarse)])
    x = (ends[:-1, None] + np.diff(ends)[:, None] * [0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)]).ravel()
    weights = np.repeat(np.diff(ends) / 2, 2)
    few, many = hats(coarse, x), hats(fine, x)
    one = np.linalg.solve((few * weights) @ few.T, (few * weights) @ many.T)
    return np.kron(one, one)


@pytest.mark.parametrize("clustered", [False, True])
def test_fewer_tents_are_a_projection(clustered):
    shape, fine, light = (25, 3, N * N), 5, random(16, N * N, 3)
    components = random(15, Q, K, *shape) if clustered else random(15, K, *shape)
    clusters = np.array([0, 1, 1, 0, 1, 0, 0]) if clustered else None
    weights = random(6, V, K)
    held = transfer(M=fine, variants={"shadowed": Variant(weights, components, clusters)})
    for coarse in (2, 3, 4, 5):
        few = np.einsum("st,...tcj->...scj", projection(fine, coarse), components).astype(np.float32)
        small = transfer(M=coarse, variants={"shadowed": Variant(weights, few, clusters)})
        expected = small.radiance(light, eye=[3, 4, 5])
        actual = held.radiance(light, eye=[3, 4, 5], tents=coarse)
        np.testing.assert_allclose(actual, expected, atol=2e-6 * np.abs(expected).max())
