"""A bounded cache of costly results, safe to use from several threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Result = TypeVar("Result")


class LruCache(Generic[Result]):
    """Least-recently-used cache of results, each under the key of its inputs.

    It holds `capacity` results, and more as long as the arrays of all together take at most `most_bytes`.
    """

    def __init__(self, capacity: int, most_bytes: int = 0) -> None:
        self._capacity, self._most_bytes = capacity, most_bytes
        self._results: dict[Hashable, Result] = {}
        self._lock = threading.Lock()

    def __getstate__(self) -> tuple[int, int]:
        """The limits: results are computed again after unpickling, and a lock belongs to its process."""
        return self._capacity, self._most_bytes

    def __setstate__(self, limits: tuple[int, int]) -> None:
        self.__init__(*limits)  # type: ignore[misc]

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
            while len(self._results) > self._capacity and self._bytes() > self._most_bytes:
                del self._results[next(iter(self._results))]
        return result

    def _bytes(self) -> int:
        """Size of the arrays of all results; a result is an array or a list of arrays."""
        lists = [result if isinstance(result, list) else [result] for result in self._results.values()]
        return sum(getattr(array, "nbytes", 1) for arrays in lists for array in arrays)
