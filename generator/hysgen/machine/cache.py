"""The last few results of a costly function, for callers that come back to them soon."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Result = TypeVar("Result")


class Recent(Generic[Result]):
    """Results by what they were made from, at most `most` of them, those asked for last. Several threads may ask."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._results: dict[Hashable, Result] = {}
        self._lock = threading.Lock()

    def of(self, key: Hashable, make: Callable[[], Result]) -> Result:
        """The result kept for `key`, or that of `make`; it is shared, so nobody may write to it."""
        with self._lock:
            if key in self._results:
                self._results[key] = self._results.pop(key)
                return self._results[key]
        result = make()
        with self._lock:
            self._results[key] = result
            while len(self._results) > self._most:
                del self._results[next(iter(self._results))]
        return result
