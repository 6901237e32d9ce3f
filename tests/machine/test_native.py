"""Host builds, first-order lags, threads and file writes of this computer."""

import importlib
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from hysgen.diagnosis import diagnose
from hysgen.errors import BuildError, HysgenError
from hysgen.fitting import fit
from hysgen.machine import files
from hysgen.machine.kernels.operators import lag_of_signals, lag_states, lag_sums
from hysgen.machine.native import Toolchain, build
from hysgen.record import Record

SOURCE = "double twice(double x) { return x + x; }\n"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path))
    return tmp_path


def test_a_library_is_compiled_once_per_source_and_flags(cache: Path) -> None:
    first = build([("twice.c", SOURCE)], "double twice(double);")
    stamp = first.path.stat().st_mtime_ns
    again = build([("twice.c", SOURCE)], "double twice(double);")
    other = build([("twice.c", SOURCE)], "double twice(double);", Toolchain(flags=("-O0",)))
    assert again.path == first.path
    assert again.path.stat().st_mtime_ns == stamp
    assert other.path != first.path
    assert first.lib.twice(2.5) == other.lib.twice(2.5) == 5.0


RUN = """
from hysgen.machine.native import build
library = build([("twice.c", "double twice(double x) { return x + x; }\\n")], "double twice(double);")
print(library.lib.twice(2.5), library.path)
"""


@pytest.mark.slow
def test_a_damaged_library_or_object_is_built_anew(cache: Path) -> None:
    def run() -> list[str]:
        done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=False)
        return done.stdout.split() or [f"{done.returncode} {done.stderr}"]

    value, library = run()
    (unit,) = cache.glob("*.o")
    assert value == "5.0"
    other = build([("twice.c", SOURCE.replace("+ x", "- x"))], "double twice(double);")
    whole = Path(library).read_bytes()
    flipped = whole[:5000] + bytes([whole[5000] ^ 255]) + whole[5001:]
    for damaged in (whole[: len(whole) // 2], b"", flipped, other.path.read_bytes()):
        Path(library).unlink()
        Path(library).write_bytes(damaged)
        unit.write_bytes(damaged)
        assert run() == ["5.0", library]


def test_a_compiler_error_is_one_line_that_names_the_place(cache: Path) -> None:
    with pytest.raises(BuildError, match=r"broken\.c:1:.*error") as fault:
        build([("broken.c", "int f(void) { return missing; }\n")], "int f(void);")
    assert "\n" not in str(fault.value)
    assert list(cache.glob("*.so")) == []


def test_a_missing_compiler_is_named(cache: Path) -> None:
    with pytest.raises(BuildError, match="no-such-cc: no such compiler"):
        build([("twice.c", SOURCE)], "double twice(double);", Toolchain("no-such-cc"))


RATES = np.array([0.3, 0.02, 1e-4])


@pytest.mark.parametrize("signals", [1, 8, 11])
def test_lag_of_several_signals_has_the_bits_of_each_lag_alone(signals: int) -> None:
    u = np.random.default_rng(3).normal(size=(signals, 500))
    rows = np.array([0, 1, 7, 8, 300, 499])
    alone = np.stack([lag_states(one, RATES[:1], one[:1].copy())[rows, 0] for one in u])
    assert np.array_equal(lag_of_signals(u, float(RATES[0]), rows), alone)
    with pytest.raises(ValueError, match="rows must rise"):
        lag_of_signals(u, 0.3, np.array([2, 2]))
    with pytest.raises(ValueError, match="rows must rise"):
        lag_of_signals(u, 0.3, np.array([500]))


def test_sum_of_lags_is_the_sum_of_the_states() -> None:
    u, start = np.random.default_rng(4).normal(size=500), np.array([0.1, -0.2, 0.3])
    # Sums of three numbers in another order differ by 2 units of the last place of their magnitudes, at most 1.
    assert np.allclose(lag_sums(u, RATES, start), lag_states(u, RATES, start).sum(axis=1), rtol=0.0, atol=1e-15)


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.mark.parametrize(
    ("module", "inner", "outer"),
    [("fitting.identify", "structure_for", fit), ("diagnosis.procedure", "prepare", diagnose)],
)
def test_one_thread_inside_in_every_thread_and_as_many_as_before_after_an_error(
    monkeypatch: pytest.MonkeyPatch, module: str, inner: str, outer: object
) -> None:
    record = Record.from_arrays(50.0 + 40.0 * np.sin(0.1 * np.arange(500)), np.arange(500.0) % 7.0, 1e-3)
    seen: list[set[int]] = []

    def looked(*_: object) -> None:
        with ThreadPoolExecutor(1) as pool:
            seen.append(threads() | pool.submit(threads).result())
        raise HysgenError("enough seen")

    monkeypatch.setattr(importlib.import_module(f"hysgen.{module}"), inner, looked)
    with threadpool_limits(2, "blas"):
        if threads() != {2}:
            pytest.skip(f"this BLAS has {threads()} threads whatever it is told")
        with pytest.raises(HysgenError, match="enough seen"):
            outer(record)  # type: ignore[operator]
        assert threads() == {2}
    assert seen == [{1}]


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
