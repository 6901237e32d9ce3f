"""File writes are atomic, also under interruption and on a full disk."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from hysgen.errors import HysgenError
from hysgen.machine import files

OLD = "the old file, whole\n"


@pytest.mark.slow
def test_a_write_that_is_killed_at_any_moment_leaves_the_old_file_or_the_new_one_whole(tmp_path: Path) -> None:
    target = tmp_path / "model.json"
    new = "x" * 3_000_000
    code = (
        "import sys; from pathlib import Path; from hysgen.machine.files import write_whole\n"
        "print('go', flush=True)\n"
        "while True: write_whole(Path(sys.argv[1]), 'x' * 3_000_000)\n"
    )
    seen = set()
    # Killed after different times, so that the blow falls into different moments of the writing.
    for wait_ms in (0, 1, 2, 3, 5, 8, 13, 21):
        target.write_text(OLD)
        with subprocess.Popen([sys.executable, "-c", code, str(target)], stdout=subprocess.PIPE) as writer:
            assert writer.stdout is not None
            writer.stdout.readline()
            time.sleep(wait_ms / 1000)
            writer.send_signal(signal.SIGKILL)
        content = target.read_text()
        assert content in (OLD, new)
        seen.add(content)
    assert OLD in seen, "no kill fell into a write: the test proves nothing"


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_write_that_fails_leaves_the_old_file_and_no_litter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    target = tmp_path / "stage.h"
    target.write_text(OLD)

    def full_disk(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, step, full_disk)
    with pytest.raises(HysgenError, match=r"stage\.h: cannot be written \(No space left on device\)"):
        files.write_whole(target, "the new file")
    assert target.read_text() == OLD
    assert [entry.name for entry in tmp_path.iterdir()] == ["stage.h"]


def test_a_link_stays_a_link_and_a_pipe_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link, pipe = tmp_path / "link.json", tmp_path / "pipe"
    link.symlink_to(tmp_path / "there" / "model.json")
    files.write_whole(link, "{}")
    assert link.is_symlink()
    assert (tmp_path / "there" / "model.json").read_text() == "{}"
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as beside:
        read = beside.submit(pipe.read_text)
        files.write_whole(pipe, "{}")
        assert read.result(timeout=600) == "{}"
    assert pipe.is_fifo()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is of Linux")
def test_a_full_device_is_said() -> None:
    with pytest.raises(HysgenError, match=r"/dev/full: cannot be written \(No space left on device\)"):
        files.write_whole(Path("/dev/full"), "{}")


def test_a_written_file_has_the_bytes_given_and_the_mode_of_any_new_file(tmp_path: Path) -> None:
    files.write_whole(tmp_path / "a" / "text.c", "line\n")
    (tmp_path / "plain").write_text("")
    assert (tmp_path / "a" / "text.c").read_bytes() == b"line\n"
    assert (tmp_path / "a" / "text.c").stat().st_mode == (tmp_path / "plain").stat().st_mode
