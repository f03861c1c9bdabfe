"""MERL's files, written by the tests as the database has them; the data themselves are not at hand."""

import itertools
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from shrm.brdf.measured import merl
from support.directions import hemisphere, turned

SCALE = np.array([1.0, 1.15, 1.66]) / 1500


def content(values: np.ndarray) -> bytes:
    """A file of a BRDF (n_h, n_d, n_phi, 3)."""
    planes = np.moveaxis(values / SCALE, -1, 0).astype("<f8")
    return struct.pack("<3i", *values.shape[:3]) + planes.tobytes()


def written(folder: Path, values: np.ndarray) -> Path:
    path = folder / "paint.binary"
    path.write_bytes(content(values))
    return path


def random(seed: int, shape: tuple[int, int, int] = (7, 6, 9)) -> np.ndarray:
    """Positive, its own mirror image, without meaning."""
    values = np.random.default_rng(seed).uniform(0.1, 1.0, (*shape, 3))
    return 0.5 * (values + values[:, :, ::-1])


def centers(shape: tuple[int, int, int]) -> list[np.ndarray]:
    """The angles of the bins' centers along each axis."""
    h, d, phi = ((np.arange(n) + 0.5) / n for n in shape)
    return [h**2 * np.pi / 2, d * np.pi / 2, phi * np.pi]


def light_and_eye(
    theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """L and V of half angles: about the normal as the pole turned by theta_h, L at (theta_d, phi_d)."""

    def in_frame_of_normal(phi: np.ndarray) -> np.ndarray:
        x, y, z = np.sin(theta_d) * np.cos(phi), np.sin(theta_d) * np.sin(phi), np.cos(theta_d)
        c, s = np.cos(theta_h), np.sin(theta_h)
        return np.stack([c * x + s * z, y, c * z - s * x], axis=-1)

    return in_frame_of_normal(phi_d), in_frame_of_normal(phi_d + np.pi)


def at_centers(shape: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """L and V at the centers of bins, and which of the bins these are: where both are above the horizon."""
    wi, wo = (w.reshape(-1, 3) for w in light_and_eye(*np.meshgrid(*centers(shape), indexing="ij")))
    above = (wi[:, 2] > 0) & (wo[:, 2] >= 0)
    return wi[above], wo[above], np.flatnonzero(above)


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(7, 6, 9), (2, 2, 2), (90, 90, 180)])
def test_values_at_the_centers_of_bins_are_read_back(tmp_path: Path, shape: tuple[int, int, int]) -> None:
    values = random(1, shape)
    material = merl.read(written(tmp_path, values))
    wi, wo, bins = at_centers(shape)
    turn = 0.7  # about the normal, which changes nothing
    expected = values.reshape(-1, 3)[bins] * wi[:, 2:]
    # Tables are float32; angles, at steps of a degree at the least, are good to 1e-11.
    np.testing.assert_allclose(material.function(turned(wi, turn), turned(wo, turn)), expected, rtol=2e-7)
    assert material.covers(wi, wo).all()
    assert (material.label, material.source, material.notes) == ("paint", "MERL", ())


def test_between_the_centers_values_are_linear_in_their_coordinates(tmp_path: Path) -> None:
    values = random(2)
    material = merl.read(written(tmp_path, values))
    wi, wo = hemisphere(5000, 3), hemisphere(5000, 4)
    h = wi + wo
    theta_h = np.arccos(h[:, 2] / np.linalg.norm(h, axis=1))
    theta_d = np.arccos(np.linalg.norm(h, axis=1) / 2)
    d = turned(wi, 0.0)
    azimuth = np.arctan2(h[:, 1], h[:, 0])
    x = (wi[:, 0] * np.cos(azimuth) + wi[:, 1] * np.sin(azimuth)) * np.cos(theta_h) - d[:, 2] * np.sin(
        theta_h
    )
    phi_d = np.arccos(np.clip(x / np.sin(theta_d), -1, 1))
    nodes = [np.sqrt(centers(values.shape[:3])[0]), *centers(values.shape[:3])[1:]]
    inside = np.stack([np.sqrt(theta_h), theta_d, phi_d], axis=1)
    inside = np.clip(inside, [axis[0] for axis in nodes], [axis[-1] for axis in nodes])
    expected = RegularGridInterpolator(nodes, values)(inside) * wi[:, 2:]
    np.testing.assert_allclose(material.function(wi, wo), expected, rtol=1e-6)


def test_a_material_is_reciprocal_and_its_own_mirror_image(tmp_path: Path) -> None:
    values = np.random.default_rng(5).uniform(0.1, 1, (7, 6, 9, 3))
    values[3:, 2] = -1  # filled
    material = merl.read(written(tmp_path, values))
    wi, wo = hemisphere(2000, 6), hemisphere(2000, 7)
    f, mirror = material.function(wi, wo) / wi[:, 2:], np.array([1, -1, 1])
    np.testing.assert_allclose(material.function(wo, wi) / wo[:, 2:], f, rtol=1e-9)
    np.testing.assert_allclose(material.function(wi * mirror, wo * mirror) / wi[:, 2:], f, rtol=1e-9)
    assert len(material.notes) == 2
    assert "from its mirror image: the mean of both is taken" in material.notes[1]
    at, to, bins = at_centers((7, 6, 9))
    expected = 0.5 * (values + values[:, :, ::-1]).reshape(-1, 3)[bins] * at[:, 2:]
    has_data = expected[:, 0] > 0
    np.testing.assert_allclose(material.function(at, to)[has_data], expected[has_data], rtol=3e-7)


# Missing data -------------------------------------------------------------------------------------


def test_missing_entries_are_filled_from_the_nearest_in_the_documented_order(tmp_path: Path) -> None:
    shape = (4, 5, 6)
    rng = np.random.default_rng(8)
    values, missing = random(9, shape), rng.random(shape) < 0.5
    missing |= missing[:, :, ::-1]
    missing[2, 3] = True  # needs theta_d
    missing[1] = True  # needs theta_h
    expected, has_data = values.copy(), ~missing
    for axis in (2, 1, 0):
        before = has_data.copy()
        for entry in itertools.product(*map(range, shape)):
            line = [(*entry[:axis], k, *entry[axis + 1 :]) for k in range(shape[axis])]
            sources = [at for at in line if before[at]]
            if sources and not before[entry]:  # of two as near the first
                expected[entry] = expected[min(sources, key=lambda at: abs(at[axis] - entry[axis]))]
                has_data[entry] = True
        expected[:, :, 3:] = expected[:, :, 2::-1]  # the rest as the mirror image
    assert has_data.all()
    values[missing, rng.integers(0, 3, missing.sum())] = -1e-3  # one channel is enough
    path = written(tmp_path, values)
    nearest, zero = merl.read(path), merl.read(path, "zero")
    assert nearest.notes == (f"{missing.sum()} of 120 entries have no data",)
    wi, wo, bins = at_centers(shape)
    np.testing.assert_allclose(nearest.function(wi, wo), expected.reshape(-1, 3)[bins] * wi[:, 2:], rtol=2e-7)
    covered = ~missing.reshape(-1)[bins]
    np.testing.assert_array_equal(nearest.covers(wi, wo), covered)
    np.testing.assert_array_equal(zero.covers(wi, wo), covered)
    expected = np.where(missing[..., None], 0, values).reshape(-1, 3)[bins] * wi[:, 2:]
    np.testing.assert_allclose(zero.function(wi, wo), expected, rtol=2e-7)


def test_the_mirror_image_has_what_an_entry_lacks(tmp_path: Path) -> None:
    values = random(10)
    values[:, :, 6:] = -1
    material = merl.read(written(tmp_path, values))
    wi, wo, bins = at_centers((7, 6, 9))
    assert material.covers(wi, wo).all()
    expected = random(10).reshape(-1, 3)[bins] * wi[:, 2:]
    np.testing.assert_allclose(material.function(wi, wo), expected, rtol=2e-7)


def test_half_a_table_is_enough(tmp_path: Path) -> None:
    values = random(16, (2, 3, 4))
    values[:, :, 2:] = -1
    assert merl.read(written(tmp_path, values)).notes == ("12 of 24 entries have no data",)


def test_zero_is_black_where_the_nearest_entry_has_no_data(tmp_path: Path) -> None:
    values = random(11)
    values[5:] = -1
    material = merl.read(written(tmp_path, values), "zero")
    wi, wo = hemisphere(2000, 12), hemisphere(2000, 13)
    covered = material.covers(wi, wo)
    assert 0 < covered.sum() < 2000
    np.testing.assert_array_equal(material.function(wi, wo).max(axis=1) > 0, covered)


# Faults -------------------------------------------------------------------------------------------


def replaced(value: float) -> bytes:
    values = random(14)
    values[1, 2, 3, 1] = value
    return content(values)


WHOLE = content(random(14))


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "starts with three numbers, this one has 0 bytes"),
        (WHOLE[:11], "starts with three numbers, this one has 11 bytes"),
        (WHOLE[:12], "7 x 6 x 9 entries take 9084 bytes, but the file has 12"),
        (WHOLE[:-1], "but the file has 9083"),
        (WHOLE + b"\0", "but the file has 9085"),
        (struct.pack("<3i", 1000, 1000, 1000) + WHOLE[12:], "at most 4000000 in all, got 1000 x 1000 x 1000"),
        (struct.pack("<3i", *3 * [2**31 - 1]), "at most 4000000 in all"),
        (struct.pack("<3i", -7, -6, 9) + WHOLE[12:], "2 or more entries along each axis"),
        (struct.pack("<3i", 378, 1, 1) + WHOLE[12:], "2 or more entries along each axis"),
        (struct.pack("<3i", 0, 6, 9), "2 or more entries along each axis"),
        (
            replaced(np.nan),
            "green must be finite and below 1e[+]30, got 1 entries that are not, the first nan",
        ),
        (replaced(-np.inf), "green must be finite"),
        (replaced(1e300), "green must be finite"),
        (content(np.full((2, 2, 2, 3), -1.0)), "has no data, every entry is negative"),
    ],
)
def test_files_that_are_wrong_are_refused_in_one_line(tmp_path: Path, data: bytes, text: str) -> None:
    path = tmp_path / "paint.binary"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=text) as caught:
        merl.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_an_oserror(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        merl.read(tmp_path / "none.binary")


def test_files_are_recognised_by_their_dimensions_and_size() -> None:
    assert merl.recognises(WHOLE[:4096], len(WHOLE))
    assert not merl.recognises(WHOLE[:4096], len(WHOLE) + 1)
    # One of the database's dimensions is one, if truncated: `read` says so.
    assert merl.recognises(struct.pack("<3i", 90, 90, 180), 1000)
    assert not merl.recognises(struct.pack("<3i", *3 * [1000]), 12 + 24 * 10**9)
    assert not merl.recognises(WHOLE[:11], 11)


def test_reading_takes_little_memory(tmp_path: Path) -> None:
    path = written(tmp_path, random(15, (90, 90, 180)))
    tracemalloc.start()
    merl.read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 150e6
