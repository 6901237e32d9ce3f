"""A bounded cache of costly results, safe to use from several threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Result = TypeVar("Result")


class LruCache(Generic[Result]):
    """Least-recently-used cache of at most `capacity` results, each under the key of its inputs."""

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._results: dict[Hashable, Result] = {}
        self._lock = threading.Lock()

    def __getstate__(self) -> int:
        """The capacity: results are computed again after unpickling, and a lock belongs to its process."""
        return self._capacity

    def __setstate__(self, capacity: int) -> None:
        self.__init__(capacity)  # type: ignore[misc]

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
            while len(self._results) > self._capacity:
                del self._results[next(iter(self._results))]
        return result
