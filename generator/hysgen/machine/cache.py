"""A bounded cache of costly results, safe to use from several threads and sent between processes without them."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar
from weakref import WeakValueDictionary

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
