"""The operations of a graph on arrays of words: what an operation leaves in every drawn sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Words = NDArray[np.uint32]


def _truth(values: NDArray[np.bool_]) -> Words:
    return values.astype(np.uint32)


def _float(operation: Callable[..., Any]) -> Callable[..., Words]:
    def computed(*words: Words) -> Words:
        with np.errstate(all="ignore"):
            result = np.asarray(operation(*(word.view(np.float32) for word in words)))
        if result.dtype == np.bool_:
            return _truth(result)
        # Which NaN results is the processor's business.
        bits = result.astype(np.float32).view(np.uint32)
        return np.where(np.isnan(result), np.uint32(0x7FC0_0000), bits)

    return computed


COMPUTED: Final[Mapping[str, Callable[..., Words]]] = {
    "addsp": _float(np.add),
    "subsp": _float(np.subtract),
    "mpysp": _float(np.multiply),
    "cmpeqsp": _float(np.equal),
    "cmpgtsp": _float(np.greater),
    "cmpltsp": _float(np.less),
    "intspu": lambda a: a.astype(np.float32).view(np.uint32),
    "add": np.add,
    "sub": np.subtract,
    "mpy32": np.multiply,
    "and": np.bitwise_and,
    "or": np.bitwise_or,
    "xor": np.bitwise_xor,
    "shl": lambda a, b: np.where(b < 32, a << (b & np.uint32(31)), np.uint32(0)),
    "shru": lambda a, b: np.where(b < 32, a >> (b & np.uint32(31)), np.uint32(0)),
    "cmpeq": lambda a, b: _truth(a == b),
    "cmpgtu": lambda a, b: _truth(a > b),
    "cmpltu": lambda a, b: _truth(a < b),
    "select": lambda c, a, b: np.asarray(np.where(c != 0, a, b), np.uint32),
}
