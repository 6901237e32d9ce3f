"""Effects of the virtual stage, found by looking into this package: here their interface.

A new effect is a frozen dataclass that derives from `Effect`, in a file of its own or beside others. No other file of
the stage or the bank changes; docs/extend.md adds one step by step.

`Action` acts in Python on the command or on the displacement; `constants` instead sets members of the compiled plant
(plant.h). The other members of `Effect` have defaults, described there. A category that is new in the bank changes what
`pair` and `poor` draw, and no other category.

Linear systems are stepped exactly over substeps for an input that is linear in time within each. The first-order hold
of `scipy.signal.cont2discrete` puts the input into the state, which fits one step length only; here the input at the
begin and at the end of a substep keep weights of their own.
"""

import functools
import importlib
import math
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hysgen.errors import HysgenError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Linear:
    """x' = A x + B v, y = c x + d v, stepped exactly over each substep for v linear over it.

    x(t + h) = phi x(t) + g0 v(t) + g1 v(t + h);  phi: (m, n, n), g0 and g1: (m, n), c and rest: (n,)
    rest is the state under a constant v = 1.
    """

    phi: Floats
    g0: Floats
    g1: Floats
    c: Floats
    rest: Floats
    d: float


def oscillator(f_Hz: float, zeta: float) -> tuple[Floats, Floats]:
    """x'' + 2 zeta w x' + w^2 x = w^2 v in the states (x, x'/w)."""
    w = 2 * math.pi * f_Hz
    return np.array([[0.0, w], [-w, -2 * zeta * w]]), np.array([0.0, w])


def exact_steps(A: Floats, B: Floats, c: Floats, d: float, h_s: Floats) -> Linear:
    """Step x' = A x + B v exactly: one matrix exponential per substep length of [A B 0; 0 0 1/h; 0 0 0]."""
    n = len(B)
    steps: dict[float, tuple[Floats, Floats, Floats]] = {}
    for h in {float(h) for h in h_s} if n else ():
        whole = np.zeros((n + 2, n + 2))
        whole[:n, :n], whole[:n, n] = A * h, B * h
        whole[n, n + 1] = 1.0
        power = expm(whole)
        steps[h] = (power[:n, :n], power[:n, n] - power[:n, n + 1], power[:n, n + 1])
    if not n:
        empty = np.zeros((len(h_s), 0))
        return Linear(np.zeros((len(h_s), 0, 0)), empty, empty, c, np.zeros(0), d)
    phi, g0, g1 = (np.stack([steps[float(h)][i] for h in h_s]) for i in range(3))
    rest: Floats = np.asarray(np.linalg.solve(A, -B), dtype=np.float64)
    return Linear(phi, g0, g1, c, rest, d)


Constants = Mapping[str, float | NDArray[Any] | Linear]

UNKNOWN = "unknown"
"""The cause that a diagnosis must name for an effect outside its vocabulary."""


class StageError(HysgenError):
    """A virtual stage is described, or driven, by numbers that are not possible."""


def require(holds: bool, complaint: str) -> None:
    """Raise StageError with `complaint` unless `holds`."""
    if not holds:
        raise StageError(complaint)


def require_finite(effect: object) -> None:
    """Raise StageError, naming effect and field, if a field of the dataclass `effect` is not a finite number."""
    name = getattr(effect, "name", type(effect).__name__)
    for item in fields(effect):  # type: ignore[arg-type]
        value = getattr(effect, item.name)
        if not (isinstance(value, int | float | np.number) and math.isfinite(value)):
            raise StageError(f"{name}.{item.name}: {value} is not a finite number; give a real one")


@dataclass(frozen=True)
class Tolerance:
    """Largest error that a diagnosed parameter may have; limit None: the error is reported and not limited.

    relative: (found - truth) / truth.   absolute: found - truth, in the parameter's unit.
    input range: (found - truth) / (largest - smallest commanded voltage).
    """

    limit: float | None = None
    kind: Literal["relative", "absolute", "input range"] = "relative"

    def error(self, estimate: float, truth: float, range_V: float) -> float:
        """Signed error of an estimate, in the measure that `kind` names."""
        unit = {"relative": truth, "absolute": 1.0, "input range": range_V}[self.kind]
        return (estimate - truth) / unit


@dataclass(frozen=True, eq=False)
class Setting:
    """The numbers of a bank scenario for which an effect is drawn.

    u_V: (n,) command. span_um: displacement over the range of the command. share: strength that the scenario has drawn
    for this effect, 0.002 to 0.05 of span_um; 0 for an effect outside the vocabulary. channels: further channels.
    """

    u_V: Floats
    Ts_s: float
    span_um: float
    share: float = 0.0
    channels: tuple[str, ...] = ()

    @property
    def span_s(self) -> float:
        """Duration of the command."""
        return self.Ts_s * len(self.u_V)

    @property
    def range_V(self) -> tuple[float, float]:
        """Smallest and largest commanded voltage."""
        return float(self.u_V.min()), float(self.u_V.max())


@dataclass(frozen=True, eq=False)
class Period:
    """One sampling period as the compiled plant runs it: h_s, (m,), substeps; lag_s, time constant of the lag."""

    Ts_s: float
    h_s: Floats
    lag_s: float


class Action:
    """An effect that acts in Python, with its own state; one object for each run.

    For each sampling period `command_V` is called once, then `added_um` once, both with the voltage given for that
    period; first with the voltage of the rest before the record, whose period ends at instant 0. A voltage that is not
    a number is replaced by the last one.
    """

    def command_V(self, u_V: float) -> float:
        """The voltage that the D/A is given in place of u_V."""
        return u_V

    def added_um(self, u_V: float) -> float:
        """The displacement added, ahead of noise, outliers and converter, at the end of the period that holds u_V."""
        return 0.0


class Effect:
    """Base of all effects; a concrete one is a frozen dataclass whose fields are the effect's parameters, with units.

    name: keyword of `Stage.with_effects`. in_vocabulary: whether the diagnosis has a cause of this name.
    active: whether the effect counts among those that a stage suffers from.
    rank: place in lists of effects. most: how many of them a stage may have at once.
    bank_index: number of the bank's category, which seeds its scenarios; None: the bank draws no such effect. Numbers
    in use are never given to another effect.
    needs_channel: whether it acts through a further channel.
    longest_substep_s: longest substep on which the plant may take the effect's signals as linear in time.
    bends_amplifier: whether the amplifier's output keeps moving after the D/A's instants.
    tolerances: by the names of `true_parameters`. A parameter without an entry has `Tolerance()`; None: not compared.
    """

    name: ClassVar[str]
    in_vocabulary: ClassVar[bool] = True
    active: ClassVar[bool] = True
    rank: ClassVar[int] = 100
    most: ClassVar[int] = 1
    bank_index: ClassVar[int | None] = None
    needs_channel: ClassVar[bool] = False
    longest_substep_s: ClassVar[float] = math.inf
    bends_amplifier: ClassVar[bool] = False
    tolerances: ClassVar[Mapping[str, Tolerance | None]] = MappingProxyType({})

    @classmethod
    def cause(cls) -> str:
        """The cause that a diagnosis must name."""
        return cls.name if cls.in_vocabulary else UNKNOWN

    @classmethod
    def made(cls, value: Any) -> Self:
        """The effect of a value given to `Stage.with_effects`: an instance, a number, or a tuple of the fields."""
        if isinstance(value, cls):
            return value
        try:
            return cls(*(value if isinstance(value, tuple) else (value,)))
        except TypeError as fault:
            raise StageError(f"{cls.name}: {value!r} makes no {cls.__name__}; give its fields") from fault

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        """Members of `plant_t` in plant.h that describe the effects of this class on a stage, () if there are none.

        The struct is zero before. An effect that acts in Python only has no constants.
        """
        return {}

    def late_s(self, Ts_s: float) -> float:
        """Time in s by which the reading is late."""
        return 0.0

    def passes_V(self, low_V: float, high_V: float) -> tuple[float, float]:
        """Range of the voltage across the ceramic for commands from low_V to high_V."""
        return low_V, high_V

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the further channels that act on the stage through the compiled plant."""
        return ()

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action | None:
        """The effect at work in Python after rest at rest_V; None if the compiled plant does everything."""
        return None

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """An effect of random strength for a bank scenario."""
        raise NotImplementedError(f"{cls.name}: bank_index without draw()")

    def true_parameters(self) -> dict[str, float]:
        """The parameters as a diagnosis should find them, by its own names, "cause.parameter"."""
        return {}


@functools.lru_cache(maxsize=1)
def effects() -> Mapping[str, type[Effect]]:
    """Class of every effect by its name, in the order of their ranks."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    classes = [kind for kind in Effect.__subclasses__() if kind.__module__.startswith(f"{__name__}.")]
    return MappingProxyType({kind.name: kind for kind in sorted(classes, key=lambda kind: (kind.rank, kind.name))})
