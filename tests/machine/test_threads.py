"""Thread limit: one BLAS thread inside a computation, the previous number afterwards."""

from __future__ import annotations

import importlib
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from hysgen.diagnosis import diagnose
from hysgen.errors import HysgenError
from hysgen.fitting import fit
from hysgen.machine.threads import THREAD, in_threads
from hysgen.record import Record


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


def test_there_are_no_more_threads_than_memory_has_room_for(monkeypatch: pytest.MonkeyPatch) -> None:
    used: set[int] = set()

    def works(item: int) -> int:
        used.add(threading.get_ident())
        time.sleep(0.01)
        return item

    monkeypatch.setattr("os.cpu_count", lambda: 4)
    monkeypatch.setattr("hysgen.machine.threads.has_room", lambda size: size < 3 * THREAD)
    assert in_threads(works, range(20)) == list(range(20))
    assert len(used) == 2
