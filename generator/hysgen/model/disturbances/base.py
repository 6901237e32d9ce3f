"""The interface of an additive term, a disturbance: regressors in float64, float32 mirror, JSON.

Model, mirror and generated C process a sample in this order:

    listen      the auxiliary channels of sample k, if the model has any
    correct     the innovation y(k) - yhat(k), where y(k) is measured (predict, learn), not in a free run or an inverse
    regressors  phi_j(k), whose weighted sum is added to y(k+1)
    advance     the state moves on by one sample

No regressor depends on the input: what the stage makes of the input is the path's part (`model.path`), and Eq. (11)
inverts the rules alone.
"""

import abc
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar

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
    """The inputs of rules and terms over one segment.

    u_V: (n,) the input of the rules, after the path; aux: channels of (n,).
    Ts_s: sampling period; first: index of sample 0 in absolute time.
    start: state of a term before sample 0, by its kind; terms that are not named start as after `_init`.
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
        """phi_j(k), one (lanes,) array each."""

    def regressors_ahead(self, samples: int) -> list[Floats32]:
        """phi_j(k + samples) of a kind whose regressors are `foreseen`, phi_j(k) of any other, (lanes,) each."""
        return self.regressors()

    @abc.abstractmethod
    def advance(self) -> None:
        """Move the state on by one sample."""


class Term(ModelPart):
    """A source of regressors phi_j(k) that do not depend on the input.

    A kind is a frozen dataclass whose fields are its parameters. The defaults here are right for one regressor without
    auxiliary channels, and for C without constants.
    """

    parts: ClassVar[Mapping[str, Mapping[str, Any]]] = MappingProxyType({})
    """Templates of C that the kind shares with others, `disturbances/<part>.c.j2`, and the constants of each."""

    @property
    def size(self) -> int:
        """Number of regressors."""
        return 1

    follows_measurements: ClassVar[bool] = False
    """Whether the term follows measured samples with the weight 1: it is not fitted, and constant in a free run."""

    foreseen: ClassVar[bool] = False
    """Whether phi_j of a later sample is known before: the inverse of a model with a delay uses phi_j(k + preview)."""

    @property
    def added(self) -> int:
        return self.size

    @abc.abstractmethod
    def describe(self) -> str:
        """One line of text: the parameters with units."""

    @abc.abstractmethod
    def regressors(self, drive: Drive) -> Floats:
        """(n, size) float64: phi_j(k)."""

    @abc.abstractmethod
    def burn_in(self, drive: Drive) -> int:
        """Samples until the influence of the initial state on the regressors has decayed to 1 %; at most n."""

    def box(self, Ts_s: float) -> TermBox:
        """What the struct of the generated C never leaves:

            x(k) in box   =>   x(k+1) in box,   |phi_j(k)| <= regressors[j]

        in float32, for the state `_init` leaves and after every later call. The proof of the
        generated C assumes the box before a call and demands the box after the call, and uses an interval of every
        number but no relation between numbers: so a bound has to be as wide as intervals of each operation make it.

        Raises ModelError if the kind gives no box.
        """
        raise ModelError(f"terms: {self.kind}: gives no box of its state; write box() in the file of the term")

    @abc.abstractmethod
    def mirror(self, lanes: int, Ts_s: float) -> Mirror:
        """The float32 reference over `lanes` instances, initialised as the generated `_init` does."""


def box_of(term: Term, Ts_s: float) -> TermBox:
    """The box of a term, `Term.box`.

    Raises ModelError if the kind of the term gives no box, or bounds another number of regressors than the term has.
    """
    box = term.box(Ts_s)
    if len(box.regressors) != term.size:
        raise ModelError(f"terms: {term.kind}: box() bounds {len(box.regressors)} regressors, the term has {term.size}")
    return box
