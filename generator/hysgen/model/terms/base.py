"""The interface of an additive term: regressors in float64, float32 mirror, linear dynamics, JSON.

Model, mirror and generated C process a sample in this order:

    listen      the auxiliary channels of sample k, if the model has any
    correct     the innovation y(k) - yhat(k), where y(k) is measured (predict, learn), not in a free run or an inverse
    regressors  phi_j(k), whose weighted sum is added to y(k+1)
    advance     u(k) acts on the state

Thus phi_j(k) does not depend on u(k), the model is affine in u(k), and Eq. (11) inverts it.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.model.intervals import Interval
from hysgen.model.part import ModelPart
from hysgen.model.structs import MirroredStruct

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Bits = NDArray[np.uint32]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Drive:
    """The inputs of the terms over one segment.

    u_V: (n,) the input of the stage, after the model's input blocks; aux: channels of (n,).
    Ts_s: sampling period; first: index of sample 0 in absolute time.
    start: state of a term before sample 0, by its kind; terms that are not named start at `Term.start`.
    innovation_um: (n,) y(k) minus its one-step prediction by the model without drift; only the drift term reads it, and
    only past samples. None in a free run without measurements.
    """

    u_V: Floats
    Ts_s: float
    aux: Mapping[str, Floats] = field(default_factory=dict)
    first: int = 0
    start: Mapping[str, Floats] = field(default_factory=dict)
    innovation_um: Floats | None = None


@dataclass(frozen=True)
class StateSpace:
    """A term that is linear in the input: x(k+1) = A x(k) + B u(k), phi(k) = C x(k).

    A: (m, m); B: (m,); C: (size, m); m may be 0 (a term that the input does not drive). The free run is stable if A is.
    The inverse at a frozen gain b has the state matrix A - B theta C / b.
    """

    A: Floats
    B: Floats
    C: Floats

    @classmethod
    def undriven(cls, size: int) -> Self:
        """The system of regressors that do not depend on the input."""
        return cls(np.zeros((0, 0)), np.zeros(0), np.zeros((size, 0)))


@dataclass(frozen=True)
class TermBox:
    """What the C struct and the regressors of a term never leave, as `Term.box` gives it.

    floats: the interval of every float of the struct, by the C path of the float inside the struct (`play[2]`), in the
    unit of the float. integers: the largest value of every integer that must not exceed a value, such as an index; an
    integer that is not named may have any value. regressors: (size,) bounds of |phi_j|, in the unit of phi_j.
    """

    floats: Mapping[str, Interval]
    regressors: tuple[float, ...]
    integers: Mapping[str, int] = field(default_factory=dict)


class Mirror(MirroredStruct, abc.ABC):
    """The float32 reference of a term over `lanes` independent instances, in the generated C's order of operations.

    Written from the equations with NumPy float32 `+ - *`, integers and comparisons only; no reduction whose order is
    not fixed. `listen` and `correct` do nothing unless a subclass overrides them.
    """

    def listen(self, aux: Mapping[str, Floats32]) -> Bits | None:
        """The auxiliary channels of sample k, (lanes,) each. Returns the bits to set in the status word."""
        return None

    def correct(self, innovation_um: Floats32) -> None:
        """Use the innovation y(k) - yhat(k) of a measured sample, (lanes,)."""

    @abc.abstractmethod
    def regressors(self) -> list[Floats32]:
        """phi_j(k), one (lanes,) array each, before u(k) acts."""

    @abc.abstractmethod
    def advance(self, u_V: Floats32) -> None:
        """Let u(k), (lanes,), act on the state."""


@runtime_checkable
class SlopeBounded(Protocol):
    """A nonlinear term with a bound of its slope that is sharper than the sum over the gains of its regressors."""

    def steepest(self, weights: Floats) -> Floats:
        """(size,) a row: row @ weights bounds |change of theta . phi| / |change of u| for theta = weights.

        For other weights theta, row @ theta is at most the bound of theta.
        """
        ...


@runtime_checkable
class DensityTerm(Protocol):
    """A term whose weights are samples of a physical density, which is not negative and is smooth."""

    def rising(self) -> Floats:
        """(n, size) rows: certified fits keep each row @ weights at 0 or at the sign of the gain."""
        ...

    def roughness(self) -> Floats:
        """(n, size) rows: ||rows @ weights||^2, in the unit of the gain squared, is the penalty of rough densities."""
        ...

    def past_input(self) -> Flags:
        """(size,) which regressors are functions of u(k-1) alone."""
        ...


class Term(ModelPart):
    """A source of regressors phi_j(k) that do not depend on u(k).

    A kind is a frozen dataclass whose fields are the shape parameters. The defaults here are right for one regressor in
    V without auxiliary channels, shape parameters that are not optimised, and C without constants.
    """

    parts: ClassVar[tuple[str, ...]] = ()
    """Templates of C that the kind shares with others, `terms/<part>.c.j2`."""

    @property
    def size(self) -> int:
        """Number of regressors."""
        return 1

    follows_measurements: ClassVar[bool] = False
    """Whether the term follows measured samples with the weight 1: it is not fitted, and constant in a free run."""

    channels: tuple[str, ...] = ()
    """Names of the auxiliary channels that the term reads."""

    @abc.abstractmethod
    def describe(self) -> str:
        """One line of text: the shape parameters with units."""

    @abc.abstractmethod
    def regressors(self, drive: Drive) -> Floats:
        """(n, size) float64: phi_j(k) before u(k) acts."""

    @abc.abstractmethod
    def start(self, u_V: float) -> Floats:
        """State after the generated `_init`: at rest under a constant input u_V."""

    @abc.abstractmethod
    def burn_in(self, drive: Drive) -> int:
        """Samples until the influence of the initial state on the regressors has decayed to 1 %; at most n."""

    @abc.abstractmethod
    def linear(self, Ts_s: float) -> StateSpace | None:
        """The term as a linear system, None if it is nonlinear."""

    def gains(self, Ts_s: float) -> tuple[float, ...]:
        """Bounds of sup |phi_j| / sup |u|, valid for changes of both too, for the small-gain test of the inverse.

        Of a linear term |C| (I - |A|)^-1 |B|, elementwise absolute values. Raises ModelError if the term is not linear
        or |A| has an eigenvalue of 1 or more.
        """
        system = self.linear(Ts_s)
        if system is not None and system.B.size == 0:
            return (0.0,) * self.size
        if system is None or np.abs(np.linalg.eigvals(np.abs(system.A))).max() >= 1.0:
            raise ModelError(f"terms: {self.kind}: its gains need a bound of their own; write gains() in its file")
        reach = np.linalg.solve(np.eye(system.B.size) - np.abs(system.A), np.abs(system.B))
        return tuple(float(gain) for gain in np.abs(system.C) @ reach)

    def box(self, v_V: Interval, Ts_s: float) -> TermBox:
        """What the struct of the generated C never leaves while the input that reaches the stage stays in v_V:

            x(k) in box, v(k) in v_V   =>   x(k+1) in box,   |phi_j(k)| <= regressors[j]

        in float32, for the state `_init` leaves under any v in v_V and after every later call. The proof of the
        generated C assumes the box before a call and demands the box after the call, and uses an interval of every
        number but no relation between numbers: so a bound has to be as wide as intervals of each operation make it.

        Raises ModelError if the kind gives no box.
        """
        raise ModelError(f"terms: {self.kind}: gives no box of its state; write box() in the file of the term")

    def shape_bounds(self, drive: Drive) -> tuple[Floats, Floats]:
        """Lower and upper bounds of `shape` that a record with this drive can identify."""
        return np.zeros(0), np.zeros(0)

    @abc.abstractmethod
    def mirror(self, u_V: Floats32, Ts_s: float) -> Mirror:
        """The float32 reference, initialised by the inputs u_V (lanes,), as the generated `_init` does."""


def loop_row(term: Term, weights: Floats, Ts_s: float) -> Floats:
    """(size,) a row: row @ weights bounds |change of theta . phi| / |change of u| for theta = weights.

    For other weights theta, row @ theta is at most the bound of theta, so a limit on row @ theta is convex in theta.
    """
    if isinstance(term, SlopeBounded):
        return term.steepest(weights)
    return np.asarray(term.gains(Ts_s)) * np.sign(weights)


def past_input(term: Term) -> Flags:
    """(size,) which regressors of a term are functions of u(k-1) alone."""
    return term.past_input() if isinstance(term, DensityTerm) else np.zeros(term.size, dtype=bool)


def box_of(term: Term, v_V: Interval, Ts_s: float) -> TermBox:
    """The box of a term, `Term.box`.

    Raises ModelError if the kind of the term gives no box, or bounds another number of regressors than the term has.
    """
    box = term.box(v_V, Ts_s)
    if len(box.regressors) != term.size:
        raise ModelError(f"terms: {term.kind}: box() bounds {len(box.regressors)} regressors, the term has {term.size}")
    return box
