"""The file of transfer: what is read is what was written, and what is not whole is told in one line."""

import json
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shrm.transfer import file
from shrm.transfer.file import TransferFileError, read, write
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.variant import Variant
from support.transfer_contents import SHAPE, K, N, Q, V, random, transfer


def arrays_of(held: RadianceTransfer) -> dict[str, np.ndarray]:
    arrays = {name: getattr(held, name) for name in ("vertices", "faces", "uv")}
    for name, variant in held.variants.items():
        arrays |= {f"{name}/{what}": array for what, array in vars(variant).items()}
    return {name: array for name, array in arrays.items() if array is not None}


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("transfer") / "good.shrt"
    transfer().save(path)
    return path.read_bytes()


def refused(path: Path, content: bytes, text: str = "", *, verify: bool = True) -> None:
    path.write_bytes(content)
    with pytest.raises(TransferFileError) as fault:
        RadianceTransfer.load(path, verify=verify)
    message = str(fault.value)
    assert message.startswith(f"{path}: ")
    assert text in message
    assert "\n" not in message
    assert len(message) < len(str(path)) + 200


# ---- The layout, as its page says


def parts(content: bytes) -> tuple[dict[str, Any], bytes]:
    """The header and the bytes of the arrays."""
    magic, version, length, total = struct.unpack_from("<8sIIQ", content)
    assert (magic, version, total) == (b"\x89SHRT\r\n\x1a", 1, len(content))
    text = content[32 : 32 + length]
    assert struct.unpack_from("<II", content, 24) == (zlib.crc32(text, zlib.crc32(content[:24])), 0)
    return json.loads(text), content[-(-(32 + length) // 64) * 64 :]


def assembled(header: dict[str, Any] | bytes, data: bytes, version: int = 1) -> bytes:
    """A file with a right checksum of whatever header."""
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    start = -(-(32 + len(text)) // 64) * 64
    fixed = struct.pack("<8sIIQ", b"\x89SHRT\r\n\x1a", version, len(text), start + len(data))
    check = struct.pack("<II", zlib.crc32(text, zlib.crc32(fixed)), 0)
    return (fixed + check + text).ljust(start, b"\0") + data


def rewritten(content: bytes, name: str, change: Callable[[np.ndarray], None]) -> bytes:
    """The file with an array changed, and its checksum right."""
    header, data = parts(content)
    entry = next(one for one in header["arrays"] if one["name"] == name)
    array = np.frombuffer(data, entry["dtype"], np.prod(entry["shape"]), entry["offset"]).copy()
    change(array.reshape(entry["shape"]))
    entry["crc32"] = f"{zlib.crc32(array.tobytes()):08x}"
    end = entry["offset"] + entry["size"]
    return assembled(header, data[: entry["offset"]] + array.tobytes() + data[end:])


def test_the_layout_is_the_one_that_is_documented(content):
    header, data = parts(content)
    expected, end = arrays_of(transfer()), 0
    for entry in header["arrays"]:
        assert entry["offset"] == -(-end // 64) * 64
        assert data[end : entry["offset"]].strip(b"\0") == b""
        end = entry["offset"] + entry["size"]
        assert f"{zlib.crc32(data[entry['offset'] : end]):08x}" == entry["crc32"]
        array = np.frombuffer(data[entry["offset"] : end], entry["dtype"]).reshape(entry["shape"])
        if entry["name"] != "quaternions":
            np.testing.assert_array_equal(array, expected.pop(entry["name"]))
        else:
            turned = Rotation.from_quat(array.astype(np.float64), scalar_first=True).as_matrix()
            np.testing.assert_allclose(turned, transfer().frames, atol=1e-6)
    assert end == len(data)
    assert not expected


# ---- What is read is what was written


@pytest.mark.parametrize("verify", [False, True])
def test_all_comes_back_bit_by_bit(tmp_path, content, verify):
    path, expected = tmp_path / "a.shrt", transfer()
    path.write_bytes(content)
    found = RadianceTransfer.load(path, verify=verify)
    for name, array in arrays_of(expected).items():
        actual = arrays_of(found)[name]
        assert actual.dtype == array.dtype, name
        np.testing.assert_array_equal(actual, array)
    # 4 float32 numbers of up to 1 make products that are off by a few 2^-24
    np.testing.assert_allclose(found.frames, expected.frames, atol=8 * 2.0**-24)
    for name in ("n", "M", "channels", "material", "report"):
        assert getattr(found, name) == getattr(expected, name)
    assert list(found.variants) == list(expected.variants)
    found.save(tmp_path / "b.shrt")
    for name, array in arrays_of(RadianceTransfer.load(tmp_path / "b.shrt")).items():
        np.testing.assert_array_equal(array, arrays_of(expected)[name])


def test_plain_data_written_again_is_the_same_file(tmp_path, content):
    """Frames go through rotations in float32, whose quaternions are off by their last digits at most."""
    (tmp_path / "a.shrt").write_bytes(content)
    write(tmp_path / "b.shrt", read(tmp_path / "a.shrt"))
    again = (tmp_path / "b.shrt").read_bytes()
    (header, data), (other, rewritten_data) = parts(content), parts(again)
    for entry, same in zip(header["arrays"], other["arrays"], strict=True):
        span = slice(entry["offset"], entry["offset"] + entry["size"])
        if entry["name"] == "quaternions":
            found, expected = (np.frombuffer(text[span], "<f4") for text in (rewritten_data, data))
            np.testing.assert_allclose(found, expected, atol=8 * 2.0**-24)
        else:
            assert rewritten_data[span] == data[span]
            assert same == entry
    assert {**header, "arrays": None} == {**other, "arrays": None}


def test_radiance_comes_back(tmp_path, content):
    (tmp_path / "a.shrt").write_bytes(content)
    light = random(10, N * N, 3)
    for name in ("shadowed", "interreflected"):
        expected = transfer().radiance(light, eye=[3, 4, 5], variant=name)
        actual = RadianceTransfer.load(tmp_path / "a.shrt").radiance(light, eye=[3, 4, 5], variant=name)
        np.testing.assert_allclose(actual, expected, atol=1e-5 * np.abs(expected).max())


def test_matrices_on_disk_are_copied_a_part_at_a_time(tmp_path, monkeypatch):
    monkeypatch.setattr(file, "_BLOCK_BYTES", 1 << 20)
    mapped = np.lib.format.open_memmap(tmp_path / "A.npy", "w+", np.float32, (100_000, *SHAPE))
    mapped[:] = random(12, 1, *SHAPE) * np.arange(100_000, dtype=np.float32)[:, None, None, None]
    held = transfer(
        vertices=random(0, len(mapped), 3),
        frames=np.tile(np.eye(3, dtype=np.float32), (len(mapped), 1, 1)),
        uv=None,
        variants={"shadowed": Variant(matrices=mapped)},
    )
    held.save(tmp_path / "a.shrt")
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        with (tmp_path / "array").open("wb") as stream:
            file._write_array(stream, mapped)
        peak = tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()
    assert peak < 2 << 20 < mapped.nbytes
    assert (tmp_path / "array").read_bytes() == mapped.tobytes()
    found = RadianceTransfer.load(tmp_path / "a.shrt", verify=True).variants["shadowed"].matrices
    np.testing.assert_array_equal(found, mapped)


def test_little_is_read_of_a_large_file(tmp_path):
    rows, block = 50_000, random(11, 5_000, *SHAPE)
    held = transfer(
        vertices=random(0, rows, 3),
        frames=np.tile(np.eye(3, dtype=np.float32), (rows, 1, 1)),
        uv=None,
        variants={"shadowed": Variant(matrices=np.tile(block, (10, 1, 1, 1)))},
    )
    held.save(tmp_path / "a.shrt")
    tracemalloc.start()
    try:
        found = RadianceTransfer.load(tmp_path / "a.shrt")
        first = found.variants["shadowed"].matrices[::5_000].copy()
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(first, np.repeat(block[:1], 10, axis=0))
    assert peak < rows * 9 * 8 * 6  # frames in float64 and what they are checked with
    base: Any = found.variants["shadowed"].matrices
    assert not base.flags.writeable
    while isinstance(base, np.ndarray) and not isinstance(base, np.memmap):
        base = base.base
    assert isinstance(base, np.memmap)


def test_whole_numbers_of_other_widths_are_written_as_they_are_read(tmp_path):
    """What numpy's argmin returns are int64."""
    clusters = np.array([0, 1, 1, 0, 1, 0, 0])
    variant = Variant(random(6, V, K), random(7, Q, K, *SHAPE), clusters)
    transfer(variants={"shadowed": variant}, faces=transfer().faces.astype(np.uint8)).save(
        tmp_path / "a.shrt"
    )
    found = RadianceTransfer.load(tmp_path / "a.shrt")
    np.testing.assert_array_equal(found.variants["shadowed"].clusters, clusters)
    np.testing.assert_array_equal(found.faces, transfer().faces)


# ---- What is not whole


def test_a_file_cut_short_anywhere_is_told(tmp_path, content):
    header, data = parts(content)
    start = len(content) - len(data)
    ends = [start + entry[what] for entry in header["arrays"] for what in ("offset",)]
    ends += [start + entry["offset"] + entry["size"] for entry in header["arrays"]]
    boundaries = [0, 8, 12, 16, 24, 28, 32, start, *ends]
    lengths = {end + k for end in boundaries for k in (-1, 0, 1)} | set(range(0, len(content), 41))
    for length in sorted(lengths & set(range(len(content)))):
        text = "is cut short" if length >= 24 else ""
        refused(tmp_path / "a.shrt", content[:length], text, verify=False)


def test_what_follows_the_end_is_told(tmp_path, content):
    refused(tmp_path / "a.shrt", content + b"\0", "damaged")


def test_a_wrong_byte_anywhere_is_told_or_read_right(tmp_path, content):
    expected, path = arrays_of(transfer()), tmp_path / "a.shrt"
    rng, right = np.random.default_rng(12), 0
    places = {*range(64), *rng.integers(0, len(content), 400).tolist()}
    for place in places:
        wrong = bytearray(content)
        wrong[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(wrong)
        try:
            found = RadianceTransfer.load(path, verify=True)
        except TransferFileError:
            continue
        right += 1  # between arrays
        for name, array in arrays_of(found).items():
            np.testing.assert_array_equal(array, expected[name])
    padding = len(content) - sum(entry["size"] for entry in parts(content)[0]["arrays"]) - 32
    assert right < len(places) * padding / len(content)


def test_matrices_are_compared_with_their_checksum_when_asked(tmp_path, content):
    wrong = content[:-2] + bytes([content[-2] ^ 1]) + content[-1:]
    refused(tmp_path / "a.shrt", wrong, "the checksum of interreflected/matrices does not match")
    RadianceTransfer.load(tmp_path / "a.shrt")


def test_other_files_and_versions_are_told(tmp_path, content):
    path = tmp_path / "a.shrt"
    refused(
        path, assembled(*parts(content), version=2), "is a transfer file of version 2, this reads version 1"
    )
    refused(path, assembled(*parts(content), version=0), "version 0")
    for other in (b"", b"\x89PNG\r\n\x1a\n" + bytes(100), content.replace(b"\r\n", b"\n", 1), b"#!/bin/sh\n"):
        refused(path, other, "is not a transfer file")
    with pytest.raises(TransferFileError, match=r"nothing\.shrt: cannot be read \(No such file"):
        RadianceTransfer.load(tmp_path / "nothing.shrt")
    with pytest.raises(TransferFileError, match="is no file"):
        RadianceTransfer.load(tmp_path)


# ---- Headers that lie, with checksums that are right


def lie(place: str, value: Any) -> Callable[[dict[str, Any]], None]:
    """Change an entry of the header, or of its first array."""

    def change(header: dict[str, Any]) -> None:
        name, _, key = place.rpartition("/")
        entry = next(one for one in header["arrays"] if one["name"] == name) if name else header
        if value is None:
            del entry[key]
        else:
            entry[key] = value

    return change


def more_arrays(header: dict[str, Any]) -> None:
    header["arrays"] *= 2


def fewer_arrays(header: dict[str, Any]) -> None:
    header["arrays"].pop()


@pytest.mark.parametrize(
    "change",
    [
        *(lie(name, None) for name in ("n", "M", "channels", "material", "report", "arrays")),
        *(lie("n", value) for value in (0, 11, 3, 2.0, True, "2", [2], 10**400)),
        *(lie("M", value) for value in (1, 34, 3, 2.0, "2")),
        *(lie("channels", value) for value in (1, 2, 3.0, True, "3")),
        *(lie("arrays", value) for value in (5, {}, [], "arrays", [5], [[]], [{}])),
        lie("material", 5),
        lie("report", [1]),
        *(lie("vertices/name", value) for value in ("faces", "a/vertices", "", "/", "x/weights", 5)),
        *(lie("vertices/dtype", value) for value in ("<f8", ">f4", "<i4", "O", "<f2", 5, ["<f4"], "<f4,<f4")),
        *(lie("vertices/offset", value) for value in (64, -64, 1, 2**62, 2**64, "0")),
        *(lie("vertices/size", value) for value in (0, -1, 2**62, 2**70, 83)),
        *(lie("vertices/crc32", value) for value in ("0" * 8, 0, "")),
        *(lie(f"{name}/shape", [2**40, 2**40]) for name in ("vertices", "shadowed/weights")),
        *(
            lie("vertices/shape", value)
            for value in (
                [],
                [0, 3],
                [-7, -3],
                [7.0, 3],
                [21],
                [3, 7],
                21,
                [True, 21],
                [7, 3] + [1] * 50_000,
            )
        ),
        lie("unshadowed/matrices/shape", [2**31, *SHAPE]),
        lie("shadowed/weights/name", "shadowed/matrices"),
        lie("shadowed/weights/name", "other/weights"),
        more_arrays,
        fewer_arrays,
    ],
)
def test_headers_that_do_not_fit_are_told_without_much_memory(tmp_path, content, change):
    header, data = parts(content)
    change(header)
    wrong = assembled(header, data)
    (tmp_path / "a.shrt").write_bytes(wrong)
    tracemalloc.start()
    try:
        refused(tmp_path / "a.shrt", wrong)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 100_000 + 30 * len(wrong)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"5",
        b"[]",
        b"{",
        b"\xff\xfe",
        b'{"n": NaN}',
        b'{"n": -Infinity}',
        b'{"n": 1e999}',
        b'{"n": ' + b"9" * 10_000 + b"}",
        b"[" * 100_000,
        b'{"a":' * 50_000,
    ],
)
def test_texts_that_are_no_header_are_told(tmp_path, content, text):
    refused(tmp_path / "a.shrt", assembled(text, parts(content)[1]), "damaged")


@pytest.mark.parametrize(
    ("size", "text"), [(2**32 - 1, "damaged"), (2**24 + 1, "damaged"), (2**24, "damaged"), (0, "damaged")]
)
def test_a_length_of_the_header_that_lies_is_told(tmp_path, content, size, text):
    wrong = content[:12] + struct.pack("<I", size) + content[16:]
    tracemalloc.start()
    try:
        refused(tmp_path / "a.shrt", wrong, text)
        assert tracemalloc.get_traced_memory()[1] < 2**24 + 200_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, np.nan) for name in ("vertices", "uv", "quaternions", "shadowed/weights")),
        *((name, np.inf) for name in ("vertices", "interreflected/components")),
        *((name, -1) for name in ("faces", "interreflected/clusters")),
        *((name, 2**31 - 1) for name in ("faces", "interreflected/clusters")),
        ("quaternions", 0.0),
    ],
)
def test_values_that_cannot_be_are_told(tmp_path, content, name, value):
    def change(array: np.ndarray) -> None:
        array[-1] = value

    refused(tmp_path / "a.shrt", rewritten(content, name, change), "damaged")
