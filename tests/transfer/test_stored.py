"""Arrays on disk that are computed part by part: stops lose nothing, and damage is computed again."""

import errno
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from shrm.transfer.rays.stored import stored
from support.stored_rows import PARTS, RIGHT, Maker, run


def test_what_is_computed_is_kept_and_read_only(tmp_path):
    first, second = Maker(), Maker()
    for maker in (first, second):
        array = run(tmp_path, maker)
        np.testing.assert_array_equal(array, RIGHT)
        assert array.dtype == np.float32
        assert not array.flags.writeable
    assert first.made == PARTS
    assert first.steps == [0, 4, 8, 10]
    assert second.made == []
    assert second.steps == [10]


@pytest.mark.parametrize(("stop", "left"), [(0, 3), (4, 2), (8, 1)])
def test_a_stop_loses_nothing(tmp_path, stop, left):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, Maker(stop))
    maker = Maker()
    np.testing.assert_array_equal(run(tmp_path, maker), RIGHT)
    assert maker.made == PARTS[3 - left :]
    assert maker.steps[0] == stop


def test_parts_may_be_others_after_a_stop(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, Maker(4))
    others = [slice(0, 3), slice(3, 6), slice(6, 10)]
    maker = Maker()
    np.testing.assert_array_equal(run(tmp_path, maker, parts=others), RIGHT)
    assert maker.made == others[1:]
    again = Maker()
    run(tmp_path, again)
    assert again.made == []


def test_what_is_about_something_else_is_replaced_and_what_was_mapped_stays(tmp_path):
    array = run(tmp_path, Maker())
    maker = Maker()
    other = stored(
        tmp_path / "rows", {"of": "that"}, (10, 2), PARTS, lambda part: maker(part)[:, 0, :2], maker.progress
    )
    assert maker.made == PARTS
    np.testing.assert_array_equal(other, RIGHT[:, 0, :2])
    np.testing.assert_array_equal(array, RIGHT)


def test_a_process_that_ends_as_it_computes_leaves_what_was_finished(tmp_path):
    code = """
import os, sys
from pathlib import Path
from support.stored_rows import Maker, run
class Ends(Maker):
    def __call__(self, part):
        if part.start == 8:
            os.kill(os.getpid(), 9)
        return super().__call__(part)
run(Path(sys.argv[1]), Ends())
"""
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)])
    assert done.returncode == -9
    maker = Maker()
    np.testing.assert_array_equal(run(tmp_path, maker), RIGHT)
    assert maker.made == PARTS[2:]


@pytest.mark.parametrize("stop", [8, 10])
@pytest.mark.parametrize("name", ["rows.npy", "rows.json"])
def test_a_wrong_byte_anywhere_is_computed_again(tmp_path, name, stop):
    try:
        run(tmp_path, Maker(stop))
    except KeyboardInterrupt:
        assert stop == 8
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    rng, path = np.random.default_rng(1), tmp_path / name
    assert sorted(path.name for path in before) == ["rows.json", "rows.npy"]
    size = len(before[path])
    for place in [*range(stop % 5, min(size, 128), 5), *range(128, size, 61)]:
        for other, content in before.items():
            other.write_bytes(content)
        wrong = bytearray(before[path])
        wrong[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(wrong)
        np.testing.assert_array_equal(run(tmp_path, Maker()), RIGHT)


@pytest.mark.parametrize("name", ["rows.npy", "rows.json"])
@pytest.mark.parametrize("keep", [None, 0, 1, 64, -1])
def test_a_file_cut_short_is_computed_again(tmp_path, name, keep):
    run(tmp_path, Maker())
    path = tmp_path / name
    content = path.read_bytes()
    path.unlink() if keep is None else path.write_bytes(content[:keep])
    maker = Maker()
    np.testing.assert_array_equal(run(tmp_path, maker), RIGHT)
    assert maker.made == PARTS


@pytest.mark.parametrize("state", [5, [], None, {"about": 1}, {"finished": 10}])
def test_a_state_of_another_kind_is_computed_again(tmp_path, state):
    run(tmp_path, Maker())
    (tmp_path / "rows.json").write_text(json.dumps(state))
    np.testing.assert_array_equal(run(tmp_path, Maker()), RIGHT)


@pytest.mark.parametrize("finished", [-1, 11, 2**70, 4.0, "10", None, True])
def test_a_number_of_rows_that_cannot_be_is_computed_again(tmp_path, finished):
    run(tmp_path, Maker())
    state = json.loads((tmp_path / "rows.json").read_bytes())
    (tmp_path / "rows.json").write_text(json.dumps({**state, "finished": finished}))
    np.testing.assert_array_equal(run(tmp_path, Maker()), RIGHT)


def test_a_disk_without_room_is_an_error_and_not_the_end(tmp_path, monkeypatch):
    def full(descriptor: int, offset: int, length: int) -> None:
        assert length >= RIGHT.nbytes
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr(os, "posix_fallocate", full)
        with pytest.raises(OSError, match="No space left"):
            run(tmp_path, Maker())
    np.testing.assert_array_equal(run(tmp_path, Maker()), RIGHT)
