"""Threads and processes: independent computations shared by several of them, one thread inside the BLAS, room to grow.

The results are those of one process, in less time. Threads gain nothing for short kernels, because between two of them
they wait for the interpreter lock. A helper is another interpreter. It never imports the user's script, as workers of
`multiprocessing` do on Windows and macOS. The calling process computes too. What a helper cannot compute, for whatever
reason, the calling process computes: a helper saves time and never decides a result.

The matrices are small. BLAS threads make a computation up to ten times slower where other threads or processes use the
same cores, and their number changes the last bits of a result.

OpenBLAS takes a buffer of 32 MB for each thread that computes. Where it gets none (`ulimit -v`, a batch system's
limit), it prints a message of its own and exits, or tries again without end; neither can be caught.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import json
import mmap
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

from hysgen.errors import HysgenError

LIBRARIES = 384 * 2**20
"""Bytes of address space that NumPy, SciPy, HDF5 and the kernels take until the first result of a fit.

Measured with glibc 2.36 and two OpenBLAS: a fit ends at 340 MB beside the interpreter, and not at 330.
"""

THREAD = 144 * 2**20
"""Bytes of address space of one more thread that computes: its stack (8 MB), glibc's arena (64 MB), two buffers."""


def has_room(size: int) -> bool:
    """Whether the process may grow by `size` bytes of address space. Nothing is kept, and no page is touched.

    True on Windows, which has no such limit for a process.
    """
    if sys.platform == "win32":
        return True
    no_reserve = getattr(mmap, "MAP_NORESERVE", 0x4000 if sys.platform == "linux" else 0)
    try:
        mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | no_reserve).close()
    except OSError:
        return False
    return True


def require_room(size: int) -> None:
    """Raise HysgenError if the process may not grow by `size` bytes of address space."""
    if not has_room(size):
        raise HysgenError(
            f"not enough memory: the libraries of hysgen take {size / 1e6:.0f} MB of address space;"
            " raise the limit of this shell or job (ulimit -v)"
        )


Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_THREADS = 4
"""Compilers that run at once; a comparison has about 12 builds."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Inside this context the BLAS uses one thread, in every thread of the process; the old limit returns afterwards.

    Also a decorator: `@one_blas_thread()`.
    """
    with ThreadpoolController().limit(limits=1, user_api="blas"):
        yield


def in_threads(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """[function(item) for item in items], computed by several threads; results in the order of the items.

    For items that wait for other programs: short kernels gain nothing (`processes`). A worker process of a pool
    computes one item at a time, because its sibling processes use the other cores. Where memory is limited, there are
    no more threads than it has room for; their number changes no result.
    """
    threads = 1 if multiprocessing.parent_process() is not None else min(os.cpu_count() or 1, MOST_THREADS)
    while threads > 1 and not has_room(threads * THREAD):
        threads -= 1
    if threads == 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))


MOST_PROCESSES = 4
"""A diagnosis has about 15 items at once, of different length; a helper takes 150 MB."""

KEPT = 2
"""Tasks that a helper keeps: their caches serve the next task with the same data."""

_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from hysgen.machine.processes import serve_as_program; serve_as_program()"
)
_pool: ContextVar[_Pool | None] = ContextVar("_pool", default=None)


def processes() -> int:
    """Processes that a computation uses: HYSGEN_PROCESSES, or one for each core that it may use up to MOST_PROCESSES.

    1 inside a worker of a process pool, because its siblings use the other cores.
    Raises HysgenError if HYSGEN_PROCESSES is no number from 1 on.
    """
    chosen = os.environ.get("HYSGEN_PROCESSES", "")
    if chosen.isdecimal() and int(chosen):
        return int(chosen)
    if chosen:
        raise HysgenError(f"HYSGEN_PROCESSES={chosen}: is no number of processes; give 1 or more, or leave it out")
    if multiprocessing.parent_process() is not None:
        return 1
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, MOST_PROCESSES)


@contextmanager
def several_processes(module: str) -> Iterator[None]:
    """Inside this context, `in_processes` shares its items with helpers, which end with the context.

    module: what a helper imports at its start, while this process computes already. Also a decorator. Where memory is
    limited, there are no more helpers than this process has room for threads that feed them.
    """
    count = processes() - 1
    while count > 0 and not has_room(count * THREAD):
        count -= 1
    if count < 1 or _pool.get() is not None or not _is_python():
        yield
        return
    pool = _Pool(count, module)
    before = _pool.set(pool)
    try:
        yield
    finally:
        _pool.reset(before)
        pool.close()


def in_processes(
    function: Callable[[Item], Result], items: Iterable[Item], cost: Callable[[Item], float] | None = None
) -> list[Result]:
    """[function(item) for item in items], shared with the helpers of the context; results in the order of the items.

    cost: items of larger cost are begun first, so that the last ones are short. Function and items are pickled once for
    each helper, and each result once. Without helpers, inside another call, or if something cannot be pickled, this
    process computes all items. Raises what function(item) raises.
    """
    listed, pool = list(items), _pool.get()
    if pool is None or len(listed) < 2:
        return [function(item) for item in listed]
    # A call inside an item finds no pool: the helpers are in use.
    before = _pool.set(None)
    try:
        order = range(len(listed))
        return pool.compute(function, listed, order if cost is None else sorted(order, key=lambda i: -cost(listed[i])))
    finally:
        _pool.reset(before)


@dataclass(eq=False)
class _Task:
    """A call of `in_processes`: numbers of items.

    todo: items that nobody has taken. refused: items that a helper could not compute. away: how many helpers compute.
    """

    message: bytes
    todo: deque[int]
    refused: deque[int] = field(default_factory=deque)
    away: int = 0
    found: dict[int, Any] = field(default_factory=dict)


class _Pool:
    """Helpers, each with a thread that hands it one item after the other."""

    def __init__(self, count: int, module: str) -> None:
        self._changed = threading.Condition()
        self._task: _Task | None = None
        self._closed = False
        self._helpers: list[_Helper] = []
        with contextlib.suppress(OSError):
            self._helpers = [_helper(module) for _ in range(count)]
        self._threads: list[threading.Thread] = []
        for helper in self._helpers:
            thread = threading.Thread(target=self._feed, args=(helper,), daemon=True)
            with contextlib.suppress(RuntimeError):  # the system has no room for a thread
                thread.start()
                self._threads.append(thread)

    def compute(self, function: Callable[[Any], Any], items: Sequence[Any], order: Iterable[int]) -> list[Any]:
        """The results of all items, which are begun in this order."""
        try:
            message = pickle.dumps((function, items), pickle.HIGHEST_PROTOCOL)
        except (pickle.PicklingError, TypeError, AttributeError):
            return [function(item) for item in items]
        task = _Task(message, deque(order))
        with self._changed:
            self._task = task
            self._changed.notify_all()
        try:
            while (index := self._next_here(task)) is not None:
                task.found[index] = function(items[index])
        finally:
            with self._changed:
                self._task = None
        return [task.found[index] for index in range(len(items))]

    def _next_here(self, task: _Task) -> int | None:
        """The next item for this process; None when the results of all are there."""
        with self._changed:
            self._changed.wait_for(lambda: task.todo or task.refused or not task.away)
            waiting = task.todo or task.refused
            return waiting.popleft() if waiting else None

    def _feed(self, helper: _Helper) -> None:
        """Hand items to the helper until the pool is closed or the helper fails."""
        lost = not helper.ready()
        last: _Task | None = None
        while not lost and (taken := self._next_away()) is not None:
            task, index = taken
            answer = helper.answer(task.message if task is not last else None, index)
            last, lost = task, answer is None
            try:
                task.found[index] = pickle.loads(answer or b"")
            except Exception:
                # Whatever fails between two processes: this one computes the item.
                task.refused.append(index)
            with self._changed:
                task.away -= 1
                self._changed.notify_all()

    def _next_away(self) -> tuple[_Task, int] | None:
        """The next item for a helper; None when the pool is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._closed or (self._task is not None and self._task.todo))
            if self._closed or self._task is None:
                return None
            self._task.away += 1
            return self._task, self._task.todo.popleft()

    def close(self) -> None:
        """End the helpers, whatever they compute."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for helper in self._helpers:
            helper.kill()
        for thread in self._threads:
            thread.join()
        for helper in self._helpers:
            helper.wait()
            helper.pipe.close()


@dataclass(frozen=True, eq=False)
class _Helper:
    """Another interpreter, which runs `serve`, and the pipe to it."""

    pipe: Connection
    kill: Callable[[], object]
    wait: Callable[[], object]

    def ready(self) -> bool:
        """Whether the helper has started."""
        return self._received() is not None

    def answer(self, message: bytes | None, index: int) -> bytes | None:
        """The pickled result of an item, empty if it failed; None if the helper has ended. message: a new task."""
        with contextlib.suppress(OSError):
            if message is not None:
                self.pipe.send_bytes(message)
            self.pipe.send(index)
            return self._received()
        return None

    def _received(self) -> bytes | None:
        with contextlib.suppress(OSError, EOFError):
            return self.pipe.recv_bytes()
        return None


def _helper(module: str) -> _Helper:
    """A helper: a fork where this process has one thread, which starts at once with all modules.

    A fork of several threads may find a lock taken for ever: there, the helper is a new interpreter. Both are away from
    the terminal, so that an interrupt from the keyboard reaches the calling process alone.
    """
    here, away = multiprocessing.Pipe()
    kill: Callable[[], object]
    wait: Callable[[], object]
    if _threads() == 1:
        forked = multiprocessing.get_context("fork").Process(target=_serve_forked, args=(away, here), daemon=True)
        forked.start()
        kill, wait = forked.kill, forked.join
    else:
        alone = dict.fromkeys(("HYSGEN_PROCESSES", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        started = subprocess.Popen(
            [sys.executable, "-c", _START, json.dumps(sys.path), module, str(away.fileno())],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **alone},
            pass_fds=[away.fileno()],
            process_group=0,
        )
        kill, wait = started.kill, started.wait
    away.close()
    return _Helper(here, kill, wait)


def _serve_forked(pipe: Connection, of_parent: Connection) -> None:
    os.setpgid(0, 0)
    of_parent.close()
    serve(pipe)


def serve_as_program() -> None:
    """`serve` in a new interpreter, whose arguments are a module to import and the number of its end of the pipe."""
    importlib.import_module(sys.argv[2])
    serve(Connection(int(sys.argv[3])))


def serve(pipe: Connection) -> None:
    """A helper: compute the items that come through the pipe until it ends."""
    # What the computation prints must not stand on the terminal.
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    tasks: deque[tuple[Callable[[Any], Any], Sequence[Any]]] = deque(maxlen=KEPT)
    _pool.set(None)
    with one_blas_thread(), contextlib.suppress(EOFError, OSError):
        pipe.send_bytes(b"ready")
        while True:
            message = pipe.recv()
            if not isinstance(message, int):
                tasks.append(message)
                continue
            function, items = tasks[-1]
            try:
                answer = pickle.dumps(function(items[message]), pickle.HIGHEST_PROTOCOL)
            except Exception:
                answer = b""
            pipe.send_bytes(answer)


def _threads() -> int:
    """Threads of this process, those of compiled libraries included; 0 if the system does not say."""
    try:
        return len(os.listdir("/proc/self/task"))
    except OSError:
        return 0


@functools.lru_cache(maxsize=1)
def _is_python() -> bool:
    """Whether this process's program is a Python interpreter, and not an application that contains one."""
    return not getattr(sys, "frozen", False) and Path(sys.executable or "").name.lower().startswith(("python", "pypy"))
