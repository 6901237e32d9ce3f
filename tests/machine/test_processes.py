"""Helper processes: they change the time of a computation and nothing else."""

import contextlib
import functools
import json
import math
import os
import pickle
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from hysgen.diagnosis import diagnose
from hysgen.machine.cache import LruCache
from hysgen.machine.processes import THREAD, in_processes, several_processes
from hysgen.record import Record
from hysgen_lab.stage import Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.studies.bank.scenario import good

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="the processes are told apart by a POSIX shell")

SLOW_PID = "sleep 0.2; echo $PPID"
"""A command that prints the process that computes it, and takes so long that every helper gets an item."""


@pytest.fixture
def two(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("HYSGEN_PROCESSES", "2")
    with several_processes("math"):
        yield


@pytest.fixture
def two_beside_a_thread(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The helper of a process with several threads, which is not forked."""
    monkeypatch.setenv("HYSGEN_PROCESSES", "2")
    ended = threading.Event()
    thread = threading.Thread(target=ended.wait)
    thread.start()
    with several_processes("math"):
        yield
    ended.set()
    thread.join()


def root(value: float) -> float:
    """math.sqrt, but helpers, which are children of the process with the tests, fail."""
    if os.environ.get("PYTEST_PID") != str(os.getpid()):
        raise OSError("not in a helper")
    return math.sqrt(value)


def ended_in_helper(value: int) -> int:
    if os.environ.get("PYTEST_PID") != str(os.getpid()):
        os._exit(1)
    time.sleep(0.05)
    return value


def written_late(path: Path) -> None:
    """Not an `exec` of a text: CPython, interrupted in one, ends with the signal even if the interrupt was caught."""
    time.sleep(60)
    path.touch()


def nested(count: int) -> list[int]:
    time.sleep(0.05)
    return in_processes(abs, [-value for value in range(count)])


@pytest.mark.parametrize("fixture", ["two", "two_beside_a_thread"])
@pytest.mark.slow
def test_items_are_shared_and_results_are_in_the_order_of_the_items(
    fixture: str, request: pytest.FixtureRequest
) -> None:
    request.getfixturevalue(fixture)
    for _ in range(20):
        found = in_processes(subprocess.getoutput, [SLOW_PID] * 6)
        if len(set(found)) > 1:
            break
    assert len(set(found)) == 2
    assert str(os.getpid()) in found
    assert in_processes(abs, range(-30, 0)) == list(range(30, 0, -1))
    assert in_processes(abs, range(-30, 0), cost=lambda value: value % 7) == list(range(30, 0, -1))
    assert in_processes(nested, [3, 1, 2]) == [[0, 1, 2], [0], [0, 1]]


@pytest.mark.parametrize("function", [root, ended_in_helper, lambda value: value])
@pytest.mark.slow
def test_what_a_helper_cannot_compute_is_computed_here(
    monkeypatch: pytest.MonkeyPatch, two: None, function: Callable[[int], float]
) -> None:
    monkeypatch.setenv("PYTEST_PID", str(os.getpid()))
    for _ in range(3):
        assert in_processes(function, [4, 4, 4, 4]) == [function(4)] * 4


def test_an_error_is_that_of_the_item_and_the_helpers_go_on(two: None) -> None:
    with pytest.raises(ValueError, match="math domain error"):
        in_processes(math.sqrt, [4.0, -1.0, -1.0, -1.0])
    assert in_processes(math.sqrt, [4.0] * 9) == [2.0] * 9


def children() -> set[str]:
    """Processes whose parent is this one: other tests may have left some, such as the tracker of multiprocessing."""
    own = set()
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # one that has ended meanwhile
            stat = path.read_text()
            if int(stat.rpartition(")")[2].split()[1]) == os.getpid():
                own.add(stat.split()[0])
    return own


def test_helpers_end_with_the_context_even_if_it_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HYSGEN_PROCESSES", "3")

    def interrupted() -> None:
        with several_processes("math"):
            threading.Timer(0.2, functools.partial(os.kill, os.getpid(), signal.SIGINT)).start()
            in_processes(written_late, [late] * 3)

    late, known = tmp_path / "helpers that were awaited", children()
    # A process that was begun in the background may ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            interrupted()
    finally:
        signal.signal(signal.SIGINT, before)
    assert children() <= known
    assert not late.exists()


def test_one_process_inside_workers_and_where_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYSGEN_PROCESSES", "1")
    with several_processes("math"):
        assert set(in_processes(subprocess.getoutput, ["echo $PPID"] * 3)) == {str(os.getpid())}


def test_no_helper_where_memory_has_no_room_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYSGEN_PROCESSES", "4")
    monkeypatch.setattr("hysgen.machine.processes.has_room", lambda size: size < THREAD)
    with several_processes("math"):
        assert set(in_processes(subprocess.getoutput, [SLOW_PID] * 3)) == {str(os.getpid())}


def test_a_cache_that_is_sent_again_is_the_same_cache() -> None:
    cache: LruCache[int] = LruCache(3)
    cache.get("key", lambda: 7)
    assert pickle.loads(pickle.dumps(cache)) is cache
    sent = pickle.dumps(cache)
    del cache
    copy = pickle.loads(sent)
    assert "key" not in copy
    assert pickle.loads(sent) is copy
    first, second = LruCache[int](3), LruCache[int](3)
    assert [pickle.loads(pickle.dumps(each)) for each in (first, second)] == [first, second], (
        "each has a name of its own"
    )


@pytest.mark.slow
def test_a_diagnosis_has_the_same_digits_with_helpers(monkeypatch: pytest.MonkeyPatch) -> None:
    stage = Stage.nominal().with_effects(creep=(0.02, 0.05, 1e4))
    u_V = good(np.random.default_rng(2), 3000, 0.0, 100.0)
    record = Record.from_arrays(u_V, measure(stage, u_V, 1e-3, seed=2).displacement_um, 1e-3)
    found = []
    for count in ("1", "3"):
        monkeypatch.setenv("HYSGEN_PROCESSES", count)
        found.append(json.dumps(diagnose(record).to_json(), sort_keys=True))
    assert found[0] == found[1]
