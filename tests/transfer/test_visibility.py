"""The folder of visibility: what is read is what was cast, stops lose nothing, and damage is told."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from shrm.transfer.rays.directions import local_directions
from shrm.transfer.rays.occluders import Occluders
from shrm.transfer.rays.visibility import Visibility
from shrm.transfer.tangent_frames import vertex_frames
from support.visibility_folders import FACES, GOOD, NORMALS, VERTICES, computed, opened


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def stopping_at(vertices: int, fault: type[BaseException] = KeyboardInterrupt) -> Callable[[int, int], None]:
    def progress(done: int, total: int) -> None:
        if done >= vertices:
            raise fault

    return progress


@pytest.mark.parametrize("hits", [True, False])
def test_what_is_read_is_what_was_cast(tmp_path, hits):
    visibility = opened(tmp_path / "new" / "folder", hits=hits)
    steps: list[tuple[int, int]] = []
    visibility.compute(lambda done, total: steps.append((done, total)))
    assert steps == [(0, 162), (50, 162), (100, 162), (150, 162), (162, 162)]
    assert len(visibility) == visibility.blocks == visibility.finished == 4
    visible, expected = Occluders(VERTICES, FACES, NORMALS).cast(
        slice(None), GOOD["frames"], GOOD["directions"]
    )
    blocks = list(visibility)
    assert [block.vertices for block in blocks] == [
        slice(0, 50), slice(50, 100), slice(100, 150), slice(150, 162)
    ]  # fmt: skip
    np.testing.assert_array_equal(np.concatenate([block.visible for block in blocks]), visible)
    if not hits:
        assert all(block.hits is None for block in blocks)
        return
    for name in ("face", "u", "v"):
        actual = np.concatenate([getattr(block.hits, name) for block in blocks])
        step = 0 if name == "face" else 0.5 / 65535 + 1e-7
        np.testing.assert_allclose(actual, getattr(expected, name), atol=step, rtol=0)


def test_parts_of_a_block_are_the_block(tmp_path):
    block = computed(tmp_path)[1]
    parts = list(block.parts(16))
    assert [part.vertices for part in parts] == [slice(50, 66), slice(66, 82), slice(82, 98), slice(98, 100)]
    np.testing.assert_array_equal(np.concatenate([part.visible for part in parts]), block.visible)
    assert [len(part.hits) for part in parts] == [np.count_nonzero(~part.visible) for part in parts]
    for name in ("face", "u", "v"):
        joined = np.concatenate([getattr(part.hits, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(block.hits, name))


@pytest.mark.parametrize("fault", [KeyboardInterrupt, RuntimeError])
@pytest.mark.parametrize("at", [0, 50, 100, 162])
def test_a_stop_loses_nothing(tmp_path, at, fault):
    whole = computed(tmp_path / "whole")
    stopped = opened(tmp_path / "stopped")
    with pytest.raises(fault):
        stopped.compute(stopping_at(at, fault))
    again = opened(tmp_path / "stopped")
    assert again.finished == -(-at // 50)
    steps: list[int] = []
    again.compute(lambda done, total: steps.append(done))
    assert steps == [step for step in (0, 50, 100, 150, 162) if step >= at]
    assert contents(tmp_path / "stopped") == contents(tmp_path / "whole")
    assert opened(tmp_path / "whole").finished == whole.blocks


def test_a_finished_folder_is_not_written_again(tmp_path):
    computed(tmp_path)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    computed(tmp_path)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


@pytest.mark.slow
def test_a_process_that_ends_as_it_writes_leaves_what_was_finished(tmp_path):
    """Ended for real: in place of the rename of the third block."""
    code = f"""
import os
from pathlib import Path
from support.visibility_folders import computed
rename = os.replace
def replace(source, target):
    if "00002" in str(target):
        os._exit(9)
    rename(source, target)
os.replace = replace
computed(Path({str(tmp_path / "killed")!r}))
"""
    done = subprocess.run([sys.executable, "-c", code], env=os.environ, check=False)
    assert done.returncode == 9
    assert any(path.suffix == ".part" for path in (tmp_path / "killed").iterdir())
    assert opened(tmp_path / "killed").finished == 2
    computed(tmp_path / "killed")
    computed(tmp_path / "whole")
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")


def test_a_block_that_the_state_does_not_name_is_computed_again(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        opened(tmp_path / "stopped").compute(stopping_at(100))
    (tmp_path / "stopped" / "visibility_00002.npz").write_bytes(b"cut")
    computed(tmp_path / "stopped")
    computed(tmp_path / "whole")
    assert contents(tmp_path / "stopped") == contents(tmp_path / "whole")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"vertices": VERTICES * 2}, "mesh_sha256"),
        ({"faces": FACES[::-1]}, "mesh_sha256"),
        ({"faces": FACES[1:]}, "faces, mesh_sha256"),
        ({"frames": vertex_frames(-NORMALS)}, "frames_sha256"),
        ({"directions": local_directions(80)}, "directions, directions_sha256"),
        ({"directions": local_directions(64)[::-1]}, "directions_sha256"),
        ({"hits": False}, "hits"),
        ({"block": 51}, "block"),
    ],
)
def test_the_visibility_of_something_else_is_refused(tmp_path, change, named):
    computed(tmp_path)
    before = contents(tmp_path)
    with pytest.raises(ValueError, match=rf"^{tmp_path}: holds .* \({named} differ\)[^\n]*$"):
        opened(tmp_path, **change)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("keep", [0, 1, 200, -2])
def test_a_state_cut_short_is_told(tmp_path, keep):
    computed(tmp_path)
    state = tmp_path / "visibility.json"
    state.write_bytes(state.read_bytes()[:keep])
    with pytest.raises(
        ValueError, match=rf"^{state}: missing, cut short or damaged: remove {tmp_path} [^\n]*$"
    ):
        opened(tmp_path)


@pytest.mark.parametrize(
    "text", ["[]", "3", '{"finished": 4}', '{"finished": [-1]}', '{"finished": [true]}', "\xff"]
)
def test_a_state_of_another_kind_is_told(tmp_path, text):
    computed(tmp_path)
    (tmp_path / "visibility.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError, match=r"^[^\n]*visibility.json: missing, cut short or damaged[^\n]*$"):
        opened(tmp_path)


def test_a_state_of_another_version_is_refused(tmp_path):
    computed(tmp_path)
    state = tmp_path / "visibility.json"
    state.write_text(json.dumps({**json.loads(state.read_text()), "version": 99}))
    with pytest.raises(ValueError, match=r"^[^\n]*\(version differ\)[^\n]*$"):
        opened(tmp_path)


@pytest.mark.parametrize("keep", [None, 0, 100, -1])
def test_a_block_cut_short_is_told(tmp_path, keep):
    visibility = computed(tmp_path)
    path = tmp_path / "visibility_00001.npz"
    content = path.read_bytes()
    path.unlink()
    if keep is not None:
        path.write_bytes(content[:keep])
    with pytest.raises(ValueError, match=rf"^{path}: missing, cut short or damaged[^\n]*$"):
        opened(tmp_path)
    with pytest.raises((ValueError, OSError)):  # if it happens while the folder is open
        visibility[1]


def test_a_block_with_a_wrong_byte_anywhere_is_told_or_read_right(tmp_path):
    visibility = computed(tmp_path)
    path, right = tmp_path / "visibility_00001.npz", visibility[1]
    content = path.read_bytes()
    told = 0
    for at in np.random.default_rng(7).integers(0, len(content), 200):
        path.write_bytes(content[:at] + bytes([content[at] ^ 0x55]) + content[at + 1 :])
        try:
            block = visibility[1]
        except ValueError as fault:
            told += str(fault).startswith(f"{path}: missing, cut short or damaged")
        else:  # a byte that means nothing, as the date's
            np.testing.assert_array_equal(block.visible, right.visible)
            np.testing.assert_array_equal(block.hits.face, right.hits.face)
    assert told > 100


def test_blocks_of_another_folder_are_told(tmp_path):
    visibility = computed(tmp_path / "this")
    other = Visibility(tmp_path / "other", **{**GOOD, "directions": local_directions(128)})
    other.compute()
    shutil.copy(tmp_path / "other" / "visibility_00001.npz", tmp_path / "this")
    with pytest.raises(ValueError, match=r"visibility_00001\.npz: missing, cut short or damaged"):
        visibility[1]


def test_what_is_not_computed_cannot_be_read(tmp_path):
    visibility = opened(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        visibility.compute(stopping_at(50))
    assert visibility[0].first == 0
    with pytest.raises(ValueError, match=rf"^{tmp_path}: 1 of 4 blocks are computed: compute first$"):
        list(visibility)
    for index in (-1, 4):
        with pytest.raises(IndexError, match=f"block {index} is not among the 4"):
            visibility[index]


def test_a_folder_that_cannot_be_made_is_the_systems_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="file"):
        opened(tmp_path / "file")
