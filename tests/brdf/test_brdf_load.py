"""Files of measurements: recognised by content; whatever is not one, or damaged, is refused in one line."""

import os
import shutil
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from shrm import Environment, prefilter_angular
from shrm.brdf import Measured, MeasurementError, filled, load, parse
from shrm.integrate.angular import integrate
from support import oracles
from support.data import require
from support.materials import write_measurements

REAL = {
    "krylon_blue.brdf": "Cornell",
    "aurora_white_rgb.bsdf": "RGL",
    "pink-felt-1d.alta": "ALTA",
}


@pytest.mark.slow
@pytest.mark.parametrize("file", REAL)
def test_content_tells_not_the_name(file: str, tmp_path: Path) -> None:
    path = tmp_path / "paint.dat"
    shutil.copy(require(f"brdf/{file}"), path)
    found = load(path)
    assert isinstance(found, Measured)
    assert found.name == f"paint ({REAL[file]})"
    assert parse(str(path)) is found


def test_a_file_that_has_not_changed_gives_the_same_material(tmp_path: Path) -> None:
    path = write_measurements(tmp_path, "Cornell")
    assert load(path) is load(str(path))
    assert load(path, extrapolate="zero") is not load(path)
    first = load(path)
    write_measurements(tmp_path, "Cornell", seed=1)
    assert load(path) is not first


def test_the_text_says_how_it_is_filled(tmp_path: Path) -> None:
    path = write_measurements(tmp_path, "Cornell").rename(tmp_path / "a+b.brdf")
    assert parse(filled(str(path), "zero")) is load(path, extrapolate="zero")
    plain = tmp_path / "b.brdf"
    shutil.copy(path, plain)
    text = filled(f"0.5*{plain} + ggx:0.1", "zero")
    assert text == f"0.5*{plain}:extrapolate=zero + ggx:0.1"
    assert filled(text, "nearest") == text
    with pytest.raises(ValueError, match="extrapolate must be"):
        parse(f"{plain}:extrapolate=maybe")


def test_a_sample_of_several_is_named(tmp_path: Path) -> None:
    path = tmp_path / "kp2.dat"
    path.write_text("1 0.3 0 0 0 0\n2 0.6 0 0 0 0\n")
    with pytest.raises(MeasurementError, match="holds 2 samples"):
        load(path)
    normal = np.array([[0.0, 0.0, 1.0]])
    values = [parse(f"{path}:sample={k}").transfer(normal, normal)[0, 0] for k in (1, 2)]
    assert values[1] == pytest.approx(2 * values[0])
    assert parse(filled(f"{path}:sample=2", "zero")).extrapolate == "zero"  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="sample must be a whole number"):
        parse(f"{path}:sample=two")
    other = tmp_path / "paint"
    shutil.copy(require("brdf/pink-felt-1d.alta"), other)
    with pytest.raises(MeasurementError, match="holds one material"):
        load(other, sample=1)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b'{"skin": {}}', "is JSON"),
        (b"\x00" * 500, "no file of measurements that is known"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n", "no file of measurements that is known"),
        (b"hello\n", "no file of measurements that is known"),
    ],
)
def test_what_is_no_measurement_is_refused_in_a_line(content: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / "thing.brdf"
    path.write_bytes(content)
    with pytest.raises(MeasurementError, match=said) as refusal:
        load(path)
    assert str(refusal.value).startswith(f"{path}: ")
    assert "\n" not in str(refusal.value)


def test_files_that_cannot_be_read_are_the_systems_errors(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "none.brdf")
    with pytest.raises(IsADirectoryError):
        load(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("file", [*REAL, "garnet_red.brdf", "vch_golden_yellow_rgb.bsdf"])
def test_damaged_files_are_read_or_refused_and_take_no_memory(file: str, tmp_path: Path) -> None:
    """Real files cut off, and with bytes changed, most of them in the first 500: 24 each, seeded."""
    whole = require(f"brdf/{file}").read_bytes()
    rng = np.random.default_rng(7)
    path = tmp_path / file
    refused = 0
    for trial in range(24):
        data = bytearray(whole)
        if trial % 2:
            del data[rng.integers(len(data)) :]
        for _ in range(rng.integers(1, 6) if trial % 2 == 0 else 0):
            data[rng.integers(len(data) if rng.random() < 0.2 else 500)] = rng.integers(256)
        path.write_bytes(data)
        tracemalloc.start()
        said = fault_of(path)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert most < 300e6
        if said is not None:
            refused += 1
            assert said.startswith(f"{path}: ")
            assert "\n" not in said
    assert refused >= 10


def fault_of(path: Path) -> str | None:
    """What is said of a file that is refused; one that is read has finite values."""
    try:
        found = load(path)
    except MeasurementError as fault:
        return str(fault)
    values = found.lobes[0].transfer(np.array([[0.6, 0.0, 0.8]]), np.array([[-0.6, 0.0, 0.8]]))
    assert np.isfinite(values).all()
    return None


@pytest.mark.parametrize("text", ["{}", "abc:{}#x", "lafortune:{}#skin"])
def test_pipes_and_devices_are_not_waited_for(text: str, tmp_path: Path) -> None:
    pipe = tmp_path / "p.brdf"
    os.mkfifo(pipe)
    with pytest.raises(ValueError, match="no regular file"):
        parse(text.format(pipe))


@pytest.mark.parametrize("number", ["9" * 401, "9" * 5000])
def test_numbers_beyond_any_are_refused(number: str, tmp_path: Path) -> None:
    path = tmp_path / "fits.json"
    path.write_text(f'{{"x": {{"kD": {number}, "A": 1, "B": 1, "C": 1, "ior": 1}}}}')
    with pytest.raises(ValueError, match=r"fits\.json"):
        parse(f"abc:{path}#x")


def test_an_argument_is_given_once(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="given twice"):
        parse(f"{tmp_path}/a.brdf:extrapolate=zero,extrapolate=nearest")


@pytest.mark.slow
@pytest.mark.parametrize("file", ["garnet_red.brdf", "krylon_blue.brdf"])
def test_black_beyond_the_data_is_black_to_integrators_too(file: str) -> None:
    """Their tables are ratios to an envelope, which is nothing there."""
    material = load(require(f"brdf/{file}"), extrapolate="zero")
    env = Environment(np.random.default_rng(5).random((16, 32, 3)).astype(np.float32))
    N, V, weights = oracles.important_views(env.pixels, 200, seed=3)
    exact = integrate(env, material, N, V, subsamples=4)
    found = prefilter_angular(env, material).radiance(N, V)
    assert oracles.relative_rms(found, exact, weights) < 0.05
