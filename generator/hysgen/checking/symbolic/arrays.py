"""NumPy arrays whose elements are operations of a graph: the reference, called with them, leaves its own dataflow.

NumPy's functions and operators on these arrays come here by its protocols `__array_ufunc__` and `__array_function__`.
An operation that is not listed here is refused with KernelRefusalError: nothing is traced by guessing.

    float32    + - *, comparisons, -x, |x|, finite or not
    uint32     + - * & | ^ << >>, % 2^n, comparisons, ~x
    bool       & | ^ ~, sum
    all        where, stack, slices, maximum and minimum, elements at a traced index

COMPUTED holds the operations of a graph on arrays of words: what an operation leaves in every drawn sample.
"""

from __future__ import annotations

import contextlib
import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, cast
from unittest import mock

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.expressions import negated, operation
from hysgen.checking.symbolic.from_c import element, replaced
from hysgen.checking.symbolic.source import KernelRefusalError

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


_FLOAT, _WORD, _TRUTH = np.dtype(np.float32), np.dtype(np.uint32), np.dtype(np.bool_)
_MAGNITUDE, _SIGN, _INFINITY = 0x7FFF_FFFF, 0x8000_0000, 0x7F80_0000

_BINARY: Final[Mapping[Any, str]] = {
    np.add: "+",
    np.subtract: "-",
    np.multiply: "*",
    np.less: "<",
    np.greater: ">",
    np.less_equal: "<=",
    np.greater_equal: ">=",
    np.equal: "==",
    np.not_equal: "!=",
    np.bitwise_and: "&",
    np.bitwise_or: "|",
    np.bitwise_xor: "^",
    np.left_shift: "<<",
    np.right_shift: ">>",
}
_COMPARISONS: Final = frozenset(["<", ">", "<=", ">=", "==", "!="])


class Symbols(NDArrayOperatorsMixin):
    """An array of float32, uint32, bool or int64 (an index) elements, each the operation that computes its bits."""

    def __init__(self, graph: Graph, ops: NDArray[np.object_], dtype: np.dtype[Any]) -> None:
        self.graph, self.ops, self.dtype = graph, ops, dtype

    @classmethod
    def of(cls, graph: Graph, words: Sequence[Op], dtype: Any = np.uint32) -> Symbols:
        """(n,) array of these operations."""
        ops = np.empty(len(words), dtype=object)
        ops[:] = words
        return cls(graph, ops, np.dtype(dtype))

    @property
    def shape(self) -> tuple[int, ...]:
        return self.ops.shape

    @property
    def size(self) -> int:
        return self.ops.size

    @property
    def T(self) -> Symbols:
        return Symbols(self.graph, self.ops.T, self.dtype)

    def __len__(self) -> int:
        return len(self.ops)

    def __iter__(self) -> Iterator[Symbols]:
        return (self[k] for k in range(len(self.ops)))

    def __bool__(self) -> bool:
        raise KernelRefusalError("the reference branches on a traced value")

    def copy(self) -> Symbols:
        return Symbols(self.graph, self.ops.copy(), self.dtype)

    def __deepcopy__(self, made: dict[int, Any]) -> Symbols:
        return self.copy()

    def reshape(self, *shape: int) -> Symbols:
        return Symbols(self.graph, self.ops.reshape(shape), self.dtype)

    def view(self, dtype: Any) -> Symbols:
        """The same bits as float32 or uint32."""
        if {self.dtype, np.dtype(dtype)} - {_FLOAT, _WORD}:
            raise KernelRefusalError(f"the bits of {self.dtype} as {np.dtype(dtype)}")
        return Symbols(self.graph, self.ops, np.dtype(dtype))

    def astype(self, dtype: Any) -> Symbols:
        """The same numbers as words; a truth is 0 or 1."""
        target = np.dtype(dtype)
        if target != self.dtype and _FLOAT in (target, self.dtype):
            raise KernelRefusalError(f"{self.dtype} becomes {target}")
        return Symbols(self.graph, self.ops, target)

    def sum(self, axis: int = 0, dtype: Any = None) -> Symbols:
        if self.dtype == _FLOAT:
            raise KernelRefusalError("a sum of floats in an order that NumPy chooses")
        rows = np.moveaxis(self.ops, axis, 0)
        total = coerced(self.graph, np.zeros(rows.shape[1:], np.uint32), np.dtype(dtype or _WORD))
        for row in rows:
            total.ops = _each(lambda a, b: self.graph.op("add", a, b), total.ops, row)
        return total

    def any(self, axis: int | None = None) -> Symbols | bool:
        """Whether one is true along an axis; without an axis: one may be true."""
        if axis is None:
            return True
        return self._along(axis, lambda a, b: self.graph.op("or", a, b))

    def max(self, axis: int = 0) -> Symbols:
        return self._along(axis, lambda a, b: _larger(self.graph, a, b, self.dtype == _FLOAT))

    def min(self, axis: int = 0) -> Symbols:
        return self._along(axis, lambda a, b: _smaller(self.graph, a, b, self.dtype == _FLOAT))

    def _along(self, axis: int, join: Callable[[Op, Op], Op]) -> Symbols:
        first, *rest = np.moveaxis(self.ops, axis, 0)
        for row in rest:
            first = _each(join, first, row)
        return Symbols(self.graph, np.asarray(first, dtype=object), self.dtype)

    def __getitem__(self, key: Any) -> Symbols:
        keys = key if isinstance(key, tuple) else (key,)
        if not any(isinstance(part, Symbols) for part in keys):
            return Symbols(self.graph, np.asarray(self.ops[key], dtype=object), self.dtype)
        distance, shape, row = self._distance(keys)
        words = list(self.ops.ravel())
        ops = [element(self.graph, words, distance, 4 * k) for k in range(row)]
        return Symbols(self.graph, Symbols.of(self.graph, ops).ops.reshape(shape), self.dtype)

    def __setitem__(self, key: Any, value: Any) -> None:
        keys = key if isinstance(key, tuple) else (key,)
        if not any(isinstance(part, Symbols) for part in keys):
            self.ops[key] = coerced(self.graph, value, self.dtype).ops
            return
        distance, _, row = self._distance(keys)
        if row != 1:
            raise KernelRefusalError("a store of a row at a traced index")
        (new,) = coerced(self.graph, value, self.dtype).ops.ravel()
        words = replaced(self.graph, list(self.ops.ravel()), distance, new)
        self.ops = Symbols.of(self.graph, words).ops.reshape(self.ops.shape)

    def _distance(self, keys: Sequence[Any]) -> tuple[Op, tuple[int, ...], int]:
        """Of the row at traced indices of one lane: its distance in bytes, the shape of the result, its words."""
        graph, traced = self.graph, [key for key in keys if isinstance(key, Symbols)]
        rest, total = self.ops.size, graph.const(0)
        for key, extent in zip(traced, self.ops.shape, strict=False):
            rest //= extent
            (index,) = key.ops.ravel()
            total = graph.op("add", graph.op("mpy32", index, graph.const(4 * rest)), total)
        if len(traced) == len(keys):
            return total, traced[0].shape + self.ops.shape[len(keys) :], rest
        # The last key counts the lanes, of which there is one.
        if len(keys) != len(traced) + 1 or rest != 1 or not np.array_equal(keys[-1], [0]):
            raise KernelRefusalError("an index of several lanes")
        return total, (1,), 1

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        out = options.pop("out", None)
        if method != "__call__" or options:
            raise KernelRefusalError(f"{ufunc.__name__}.{method}")
        result = self._called(ufunc, inputs)
        if out:
            out[0].ops, out[0].dtype = result.ops, result.dtype
        return result

    def _called(self, ufunc: Any, inputs: Sequence[Any]) -> Symbols:
        graph = self.graph
        if len(inputs) == 1:
            return self._unary(ufunc)
        dtype = _common(inputs)
        a, b = (coerced(graph, operand, dtype) for operand in inputs)
        floating = dtype == _FLOAT
        if ufunc is np.remainder and not floating:
            (size,) = {op.number for op in b.ops.ravel() if op.kind == "const"} or {0}
            if size.bit_count() != 1:
                raise KernelRefusalError("a remainder of a division by other than a power of two")
            return Symbols(graph, _each(lambda x, _: graph.op("and", x, graph.const(size - 1)), a.ops, b.ops), dtype)
        if ufunc in _EXTREMES:
            return Symbols(graph, _each(lambda x, y: _EXTREMES[ufunc](graph, x, y, floating), a.ops, b.ops), dtype)
        symbol = _BINARY.get(ufunc)
        if symbol is None:
            raise KernelRefusalError(f"{ufunc.__name__} of arrays")
        ops = _each(lambda x, y: operation(graph, None, symbol, x, y, floating), a.ops, b.ops)
        return Symbols(graph, ops, _TRUTH if symbol in _COMPARISONS else dtype)

    def _unary(self, ufunc: Any) -> Symbols:
        graph, dtype = self.graph, self.dtype
        made: dict[tuple[Any, np.dtype[Any]], Callable[[Op], Op]] = {
            (np.negative, _FLOAT): lambda x: graph.op("xor", x, graph.const(_SIGN)),
            (np.absolute, _FLOAT): lambda x: graph.op("and", x, graph.const(_MAGNITUDE)),
            (np.isfinite, _FLOAT): lambda x: graph.op(
                "cmpltu", graph.op("and", x, graph.const(_MAGNITUDE)), graph.const(_INFINITY)
            ),
            (np.invert, _TRUTH): lambda x: negated(graph, x),
            (np.invert, _WORD): lambda x: graph.op("xor", x, graph.const(-1)),
        }
        if (ufunc, dtype) not in made:
            raise KernelRefusalError(f"{ufunc.__name__} of {dtype}")
        ops = _each(made[ufunc, dtype], self.ops)
        return Symbols(graph, ops, _TRUTH if ufunc is np.isfinite else dtype)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function not in _FUNCTIONS:
            raise KernelRefusalError(f"numpy.{function.__name__} of arrays")
        return _FUNCTIONS[function](self.graph, *args, **kwargs)


def coerced(graph: Graph, value: Any, dtype: np.dtype[Any]) -> Symbols:
    """An array with elements of `dtype`; numbers become constants."""
    if isinstance(value, Symbols):
        return value if value.dtype == dtype else value.astype(dtype)
    numbers = np.asarray(value)
    if numbers.dtype == object:
        raise KernelRefusalError("a list of arrays")
    exact = numbers.astype(dtype)
    if not np.array_equal(exact, numbers, equal_nan=exact.dtype == _FLOAT):
        raise KernelRefusalError(f"{value} as {dtype}")
    bits = np.ascontiguousarray(exact).view(_WORD) if dtype == _FLOAT else exact.astype(_WORD)
    return Symbols(graph, _each(lambda word: graph.const(int(word)), bits.reshape(exact.shape)), dtype)


def with_symbols(graph: Graph, given: Any, made: dict[int, Any] | None = None) -> Any:
    """A copy of `given` in which every array of 32-bit numbers is one of constants, also inside lists and objects."""
    made = {} if made is None else made
    if id(given) in made:
        return made[id(given)]
    match given:
        case np.ndarray():
            changed: Any = coerced(graph, given, given.dtype) if given.dtype in (_FLOAT, _WORD) else given
        case list() | tuple() if not hasattr(given, "_fields"):
            changed = type(given)(with_symbols(graph, item, made) for item in given)
        case dict():
            changed = {key: with_symbols(graph, item, made) for key, item in given.items()}
        case _ if hasattr(given, "__dict__") and not isinstance(given, type):
            changed = made[id(given)] = copy.copy(given)
            for name, value in vars(given).items():
                object.__setattr__(changed, name, with_symbols(graph, value, made))
        case _:
            changed = given
    made[id(given)] = changed
    return changed


def _larger(graph: Graph, a: Op, b: Op, floating: bool) -> Op:
    return graph.select(graph.op("cmpltsp", a, b), b, a) if floating else graph.select(graph.op("cmpgtu", b, a), b, a)


def _smaller(graph: Graph, a: Op, b: Op, floating: bool) -> Op:
    return graph.select(graph.op("cmpltsp" if floating else "cmpltu", b, a), b, a)


_EXTREMES: Final[Mapping[Any, Callable[[Graph, Op, Op, bool], Op]]] = {np.maximum: _larger, np.minimum: _smaller}


def _each(function: Callable[..., Op], *operands: Any) -> NDArray[np.object_]:
    return np.asarray(np.frompyfunc(function, len(operands), 1)(*operands), dtype=object)


def _common(inputs: Sequence[Any]) -> np.dtype[Any]:
    """The type of an operation: that of its arrays; a number of Python takes theirs, and a truth is a word."""
    dtypes = {operand.dtype for operand in inputs if hasattr(operand, "dtype")}
    if _WORD in {operand.dtype for operand in inputs if isinstance(operand, Symbols)}:
        dtypes.discard(np.dtype(np.int64))  # constants, which have to fit
    if _TRUTH in dtypes and len(dtypes) > 1:
        dtypes.discard(_TRUTH)
    if len(dtypes) != 1:
        raise KernelRefusalError(f"an operation of {' and '.join(sorted(map(str, dtypes)))}")
    (dtype,) = dtypes
    return cast("np.dtype[Any]", dtype)


def _where(graph: Graph, condition: Any, yes: Any, no: Any) -> Symbols:
    dtype = _common([yes, no])
    chosen = coerced(graph, condition, _TRUTH)
    a, b = coerced(graph, yes, dtype), coerced(graph, no, dtype)
    return Symbols(graph, _each(graph.select, chosen.ops, a.ops, b.ops), dtype)


def _stack(graph: Graph, arrays: Sequence[Any], axis: int = 0) -> Symbols:
    dtype = _common(arrays)
    return Symbols(graph, np.stack([coerced(graph, array, dtype).ops for array in arrays], axis), dtype)


def _filled(graph: Graph, like: Any, value: Any, dtype: Any = None) -> Symbols:
    made = coerced(graph, value, np.dtype(dtype or like.dtype))
    return Symbols(graph, np.broadcast_to(made.ops, like.shape).copy(), made.dtype)


_FUNCTIONS: Final[Mapping[Any, Callable[..., Any]]] = {
    np.where: _where,
    np.stack: _stack,
    np.full_like: _filled,
    np.zeros_like: lambda graph, like, dtype=None: _filled(graph, like, 0, dtype),
    np.empty_like: lambda graph, like, dtype=None: _filled(graph, like, 0, dtype),
    np.ones_like: lambda graph, like, dtype=None: _filled(graph, like, 1, dtype),
    np.shape: lambda _, array: array.shape,
    np.repeat: lambda graph, array, times, axis: Symbols(graph, np.repeat(array.ops, times, axis), array.dtype),
    np.tile: lambda graph, array, times: Symbols(graph, np.tile(array.ops, times), array.dtype),
}


@contextlib.contextmanager
def traced() -> Iterator[None]:
    """While it is open, `np.array`, `np.asarray` and `np.ascontiguousarray` pass these arrays on.

    They are the three functions that NumPy's protocols do not hand over.
    """

    def passing(original: Callable[..., Any]) -> Callable[..., Any]:
        def made(value: Any, dtype: Any = None, **options: Any) -> Any:
            if isinstance(value, Symbols):
                return value.copy() if dtype is None else value.astype(dtype)
            if isinstance(value, list) and any(isinstance(item, Symbols) for item in value):
                return cast(Any, np.stack)(value)
            return original(value, dtype=dtype, **options)

        return made

    with contextlib.ExitStack() as patches:
        for name in ("array", "asarray", "ascontiguousarray"):
            patches.enter_context(mock.patch.object(np, name, passing(getattr(np, name))))
        yield
