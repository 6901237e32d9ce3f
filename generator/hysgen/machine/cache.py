"""A bounded cache of costly results, safe to use from several threads and sent between processes without them."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import pickle
import shutil
import threading
import uuid
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar
from weakref import WeakValueDictionary

import numpy as np

from hysgen.errors import HysgenError
from hysgen.machine.files import digest, unsealed, write_sealed
from hysgen.machine.native import cache_folder

Result = TypeVar("Result")

_by_name: WeakValueDictionary[str, LruCache[Any]] = WeakValueDictionary()


class LruCache(Generic[Result]):
    """Least-recently-used cache of results, each under the key of its inputs.

    It holds `capacity` results, and more as long as the arrays of all together take at most `most_bytes`.
    Pickled, it is a name and the limits: each process computes its own results, because they are large. In a process
    that holds the cache of this name, it becomes that cache, so objects sent one after the other keep sharing it.
    """

    def __init__(self, capacity: int, most_bytes: int = 0, name: str = "") -> None:
        self._capacity, self._most_bytes = capacity, most_bytes
        self._name = name or uuid.uuid4().hex
        self._results: dict[Hashable, Result] = {}
        self._lock = threading.Lock()
        _by_name[self._name] = self

    def __reduce__(self) -> tuple[Callable[..., LruCache[Any]], tuple[int, int, str]]:
        return _cache, (self._capacity, self._most_bytes, self._name)

    def __contains__(self, key: Hashable) -> bool:
        with self._lock:
            return key in self._results

    def get(self, key: Hashable, compute: Callable[[], Result]) -> Result:
        """The cached result of `key`, or else compute(), which is then cached. All callers share it: do not modify it.

        `compute` runs outside the lock, so two threads that miss the same key at once both compute it.
        """
        with self._lock:
            if key in self._results:
                self._results[key] = self._results.pop(key)
                return self._results[key]
        result = compute()
        with self._lock:
            self._results[key] = result
            while len(self._results) > self._capacity and not (self._most_bytes and self._bytes() <= self._most_bytes):
                del self._results[next(iter(self._results))]
        return result

    def _bytes(self) -> int:
        """Size of the arrays of all results; a result is an array or a list of arrays."""
        lists = [result if isinstance(result, list) else [result] for result in self._results.values()]
        return sum(getattr(array, "nbytes", 1) for arrays in lists for array in arrays)


def _cache(capacity: int, most_bytes: int, name: str) -> LruCache[Any]:
    """The cache of this name in this process."""
    return _by_name.get(name) or LruCache(capacity, most_bytes, name)


def resumed(inputs: Sequence[str], sources: Path, compute: Callable[[], Result]) -> Result:
    """The kept result of `compute` for these inputs, or else compute(), which is then kept.

    sources: folder of the Python files that the result depends on. A result that cannot be kept is returned too.
    """
    return _kept(_path("step", inputs, sources).with_suffix(".pickle"), compute)


@dataclass(frozen=True)
class Steps:
    """Results of many steps of one computation, each in its own file of `folder` under the digest of its inputs."""

    folder: Path

    def get(self, inputs: Any, compute: Callable[[], Result]) -> Result:
        """The kept result of `compute` for these inputs, or else compute(), which is then kept."""
        return _kept(self.folder / f"{content_digest(inputs)}.pickle", compute)


def steps(inputs: Sequence[str], sources: Path) -> Steps:
    """The kept steps of a computation with these inputs; arguments as of `resumed`."""
    return Steps(_path("steps", inputs, sources))


def content_digest(value: Any) -> str:
    """Digest of a value from arrays, mappings, sequences, dataclasses (their fields with a repr) and plain values."""
    hasher = hashlib.sha256()

    def add(part: Any) -> None:
        hasher.update(f"{type(part).__name__}(".encode())
        if isinstance(part, np.ndarray):
            hasher.update(f"{part.dtype}{part.shape}".encode() + np.ascontiguousarray(part).tobytes())
        elif isinstance(part, Mapping):
            add([item for key in sorted(part) for item in (key, part[key])])
        elif isinstance(part, list | tuple):
            for item in part:
                add(item)
        elif dataclasses.is_dataclass(part):
            add([getattr(part, item.name) for item in dataclasses.fields(part) if item.repr])
        else:
            hasher.update(repr(part).encode())
        hasher.update(b")")

    add(value)
    return hasher.hexdigest()[:32]


def _kept(path: Path, compute: Callable[[], Result]) -> Result:
    if (data := unsealed(path)) is not None:
        with contextlib.suppress(pickle.PickleError, AttributeError, ImportError):
            result: Result = pickle.loads(data)
            return result
    result = compute()
    with contextlib.suppress(HysgenError, pickle.PickleError, TypeError, AttributeError):
        write_sealed(path, pickle.dumps(result))
    return result


def forget(inputs: Sequence[str], sources: Path) -> None:
    """Remove the kept result and the kept steps for these inputs, if there are any."""
    with contextlib.suppress(OSError):
        _path("step", inputs, sources).with_suffix(".pickle").unlink()
    shutil.rmtree(_path("steps", inputs, sources), ignore_errors=True)


def _path(kind: str, inputs: Sequence[str], sources: Path) -> Path:
    code = [digest(path.read_bytes()) for path in sorted(sources.rglob("*")) if path.suffix in (".py", ".c", ".h")]
    return cache_folder() / f"{kind}-{digest(chr(0).join([*inputs, *code]).encode())[:32]}"
