"""A part of a stage as a fit sees it: its shape parameters, and methods for the places in the chain where it can act.

    u -> apply -> h(u) -> slow states -> modes -> 1/(lag s + 1) -> delay -> (1 + gain change)  + added columns

Blocks and terms of a model are such parts, so that the probe of a diagnosis fits what is delivered: optimiser, C, model
file and examples see both alike (`ModelPart`). A change that no model is extended by is declared in the file of its
cause (`hysgen.diagnosis.causes`). A part is a frozen dataclass with a table of its shape parameters. It overrides the
methods of the places where it acts; the inherited methods have no effect.
"""

import abc
import dataclasses
import importlib
import math
import pkgutil
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self, get_type_hints

import numpy as np
from numpy.typing import NDArray

from hysgen.model.structs import Member, Quantity

Floats = NDArray[np.float64]

STEP = 1e-5
"""Step of a forward difference in a parameter of the order of 1, or in a logarithm."""

EDGE = 1e-3
"""Share of the range of a parameter within which its value lies at the bound: a fit that ends there has no optimum."""


@dataclass(frozen=True)
class Extent:
    """Sampling period, longest run and range of the command: the arguments of bounds and steps of parameters."""

    Ts_s: float
    span_s: float
    low_V: float
    high_V: float

    @property
    def middle_V(self) -> float:
        return 0.5 * (self.low_V + self.high_V)

    @property
    def half_V(self) -> float:
        return 0.5 * (self.high_V - self.low_V)


@dataclass(frozen=True)
class ShapeParameter:
    """One shape parameter of a part.

    field: attribute of the part; unit: its unit; bounds: lowest and highest value for an extent, in that unit.
    logarithm: whether the coordinate of the fit is ln(value). step: step of the forward difference in this coordinate.
    order: p where the standard error falls as n^(-p/2) with the number of samples n: 3 for a frequency, else 1.
    closed: whether a fit may end at the lowest value, because smaller ones have nearly the same effect; closed_above:
    whether at the highest.
    """

    field: str
    unit: str
    bounds: Callable[[Extent], tuple[float, float]]
    logarithm: bool = False
    step: Callable[[Extent], float] = lambda extent: STEP
    order: float = 1.0
    closed: bool = False
    closed_above: bool = False

    def coordinate(self, value: float) -> float:
        """The coordinate of a value: ln(value) or the value itself."""
        return math.log(value) if self.logarithm else value

    def value(self, coordinate: float) -> float:
        """Inverse of `coordinate`."""
        return math.exp(coordinate) if self.logarithm else coordinate

    def inside(self, value: float, extent: Extent) -> bool:
        """Whether the value lies between its bounds and at neither of them, but for those that are closed."""
        low, high = (self.coordinate(bound) for bound in self.bounds(extent))
        edge, at = EDGE * (high - low), self.coordinate(value)
        return (self.closed or low + edge < at) and (self.closed_above or at < high - edge)

    def bounded(self, coordinate: float, extent: Extent) -> float:
        """The coordinate, clamped to its bounds."""
        low, high = (self.coordinate(bound) for bound in self.bounds(extent))
        return min(max(coordinate, low), high)


def octaves(count: float) -> float:
    """Number of parameters that a function counts as which is given by `count` weights: 1 + log2(count).

    The weights of a smooth function decrease from each octave of its detail to the next, so an octave counts as one.
    """
    return 1.0 + math.log2(count)


@dataclass(frozen=True)
class Mode:
    """share (1 + early_s s) / (1 + 2 zeta s/w + s^2/w^2), w = 2 pi f_Hz; the rest responds without a mode."""

    f_Hz: float
    zeta: float
    share: float
    early_s: float = 0.0


class SlowStates(Protocol):
    """y = x + amount sum_i s_i,  s_i(k+1) = s_i(k) + a_i (x(k) - s_i(k)), with the a_i = `rates`; the block `creep`."""

    @property
    def amount(self) -> float: ...

    def rates(self, Ts_s: float) -> Floats: ...


class RunSignals(Protocol):
    """Signals of one run for an added column: the command and the auxiliary channels, (n,) each.

    whole: samples of the segment; stride: periods between two samples; time_s: (n,) time since its start.
    """

    @property
    def u_V(self) -> Floats: ...

    @property
    def aux(self) -> Mapping[str, Floats]: ...

    @property
    def whole(self) -> int: ...

    @property
    def stride(self) -> int: ...

    def time_s(self, Ts_s: float) -> Floats: ...

    def __hash__(self) -> int: ...


class Part:
    """One part of the chain: a frozen dataclass that overrides the methods of the places where it acts.

    cause: name of the part's cause; prefix of the parameter names.
    place: position in the chain, rising from the command to the sensor; order of the coordinates and columns.
    table: the parameters that are fitted; a parameter whose attribute is None is not fitted.
    amplifies: whether the part overrides `apply`, `averaged` or `relaxation` and acts before the hysteresis or in it; a
    change of such a part requires a new evaluation of the hysteresis.
    flexible: whether the part may take any course in time, so that what it explains may also be misfit (`score`).
    timed: whether the added columns depend on time alone, so that they can be computed at some samples only.
    """

    cause: ClassVar[str] = ""
    place: ClassVar[int] = 0
    table: ClassVar[tuple[ShapeParameter, ...]] = ()
    amplifies: ClassVar[bool] = False
    flexible: ClassVar[bool] = False
    timed: ClassVar[bool] = False

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        """Name "cause.field" and table entry of each fitted parameter."""
        fitted = (entry for entry in self.table if getattr(self, entry.field) is not None)
        return tuple((f"{self.cause}.{entry.field}", entry) for entry in fitted)

    @property
    def values(self) -> tuple[float, ...]:
        """Value of each fitted parameter, in the order of `parameters`."""
        return tuple(float(getattr(self, entry.field)) for _, entry in self.parameters)

    def with_values(self, values: Sequence[float]) -> Self:
        """The part with other values of its fitted parameters; inverse of `values`."""
        fields = [entry.field for _, entry in self.parameters]
        return dataclasses.replace(self, **dict(zip(fields, values, strict=True))) if fields else self  # type: ignore[type-var]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters of the part, of its added columns too: equal for parts of equal structure."""
        return (self.cause, *(name for name, _ in self.parameters), *(f"column {i}" for i in range(self.added)))

    def behind(self, lag_s: float) -> Self:
        """The part in a chain with this lag."""
        return self

    # Before the hysteresis.

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        """(n,) voltage behind this part for the voltage before it; start: state before, by default rest under u(0)."""
        return u_V

    def apply_held(self, u_V: Floats, held: NDArray[np.int64], Ts_s: float) -> Floats:
        """`apply` for voltages u_V, (k,), that follow each other after held, (k,), samples (`probe.History`)."""
        return self.apply(u_V, Ts_s)

    def averaged(self, columns: Floats, v_V: Floats, Ts_s: float) -> Floats:
        """(p, n) means over each sampling period of the columns of h, given at the samples of v_V, (n,)."""
        return columns

    # In the hysteresis.

    @property
    def relaxation(self) -> float:
        """Relaxation of the plays in half-widths (`fitting.operator.Operator`); 0 for plays that do not relax."""
        return 0.0

    # Behind the hysteresis; linear.

    def slow_states(self, span_s: float) -> SlowStates | None:
        """First-order states with the hysteresis as input, over a segment of span_s; at most one part may have them."""
        return None

    @property
    def past(self) -> tuple[float, float] | None:
        """Voltage in V at which the slow states rested, and time in s since then, before a segment; None: its first."""
        return None

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Second-order modes in parallel."""
        return ()

    @property
    def late(self) -> float:
        """Delay in samples, whole or fractional."""
        return 0.0

    def gain_change(self, t_s: Floats) -> Floats | float:
        """(n,) relative change of the stage's gain at times t_s after the start of the segment, or 0."""
        return 0.0

    # Beside the hysteresis.

    @property
    def added(self) -> int:
        """Number of added columns."""
        return 0

    @property
    def weight_orders(self) -> float:
        """Number of weights of the added columns that counts in the score (`octaves`)."""
        return float(self.added)

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        """Whether the effect differs from one pass of the stage through the same states to the next.

        The misfit of the hysteresis repeats there, so it averages out along such an effect.
        """
        return False

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        """`added` columns of one run, (n,) each. seen: applies the chain's lag and delay to a signal, (n,)."""
        return []

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        """Key for a cache of the columns; equal keys imply equal columns."""
        return self


READERS: Mapping[Any, Callable[[Any], Any]] = {
    float: float,
    float | None: lambda value: None if value is None else float(value),
    int: int,
    str: str,
    tuple[float, ...]: lambda values: tuple(float(value) for value in values),
    tuple[str, ...]: lambda values: tuple(str(value) for value in values),
}
"""How a field is read, by its annotation; bool is strict."""


def to_plain(part: Any) -> dict[str, Any]:
    """Fields of a dataclass by name, in their order, tuples as lists; exact."""
    values = {item.name: getattr(part, item.name) for item in dataclasses.fields(part)}
    return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


def arguments(kind: type[Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a dataclass out of `to_plain` of it; a field with a default may be missing.

    Raises KeyError if a field is missing, TypeError or ValueError if a value is malformed or the annotation of a field
    is not in READERS.
    """
    values: dict[str, Any] = {}
    hints = get_type_hints(kind)
    for item in dataclasses.fields(kind):
        if item.name not in data and item.default is not dataclasses.MISSING:
            continue
        value, hint = data[item.name], hints[item.name]
        if hint is bool:
            if not isinstance(value, bool):
                raise TypeError(f"{item.name} must be true or false")
            values[item.name] = value
        elif hint in READERS:
            values[item.name] = READERS[hint](value)
        else:
            raise TypeError(f"{item.name}: no reader for {hint}; write to_json() and from_json() of {kind.__name__}")
    return values


Words = NDArray[np.uint32] | NDArray[np.float32]


class ModelPart(Part, abc.ABC):
    """A part of a model: parameters and, in C, a struct of its own. The defaults are those of a part without any."""

    kind: ClassVar[str]
    channels: tuple[str, ...] = ()
    """Names of the auxiliary channels that it reads."""
    two_words: ClassVar[bool] = False
    """Whether its states are sums of two words (`float32_arithmetic`)."""

    quantities: ClassVar[Mapping[str, Quantity]] = {}
    """Meaning and unit of every array of `constants`, by its name."""

    def members(self) -> tuple[Member, ...]:
        """The members of the C struct that keeps the state, in its order, with units; () without a state.

        Scalars and arrays of up to two sizes. The mirror has an attribute of the name of each.
        """
        return ()

    def constants(self, Ts_s: float) -> Mapping[str, Words]:
        """The 32-bit numbers that the C needs, by the name of their array in `<name>_params.h` (see `quantities`)."""
        return {}

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, exact; includes "kind"."""
        return {"kind": self.kind, **to_plain(self)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Inverse of to_json. Raises KeyError, TypeError or ValueError on malformed data."""
        return cls(**arguments(cls, data))

    @classmethod
    def kinds_in(cls, package: str, path: Iterable[str]) -> Mapping[str, type[Self]]:
        """The classes of the modules of a package that derive from this one, by their kind, in its order."""
        for module in pkgutil.iter_modules(path):
            importlib.import_module(f"{package}.{module.name}")
        near = cls.__subclasses__()
        every = [*near, *(further for kind in near for further in kind.__subclasses__())]
        inside = (kind for kind in every if kind.__module__.startswith(package))
        return {kind.kind: kind for kind in sorted(inside, key=lambda kind: kind.kind)}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """One part with random parameters for each form of the C, first the form that a diagnosis delivers.

        `verify` compares models of them bit for bit.
        """
        return (cls(),)
