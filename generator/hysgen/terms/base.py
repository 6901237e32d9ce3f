"""The contract of an extension term: its regressors in float64, its float32 mirror, and its place in a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]


@dataclass(frozen=True)
class Drive:
    """What drives a term over one segment: the input, auxiliary channels and the time grid; never the displacement.

    u_V: (n,); aux: channels of (n,); Ts_s: sampling period; first: index of sample 0 in absolute time.
    """

    u_V: Floats
    Ts_s: float
    aux: Mapping[str, Floats] = field(default_factory=dict)
    first: int = 0


class Mirror(Protocol):
    """The float32 reference of a term over `lanes` independent instances, in the generated C's order of operations.

    Written from the equations with NumPy float32 `+ - *` and comparisons only; no reduction whose order is not fixed.
    """

    def regressors(self) -> list[Floats32]:
        """phi_j(k), one (lanes,) array each, before u(k) acts."""
        ...

    def advance(self, u_V: Floats32) -> None:
        """Let u(k), (lanes,), act on the state."""
        ...

    def state(self) -> list[Floats32]:
        """Every float of the C struct of this term, in its order, (lanes,) each; compared bit for bit."""
        ...


@runtime_checkable
class Term(Protocol):
    """A source of regressors phi_j(k) that depend on the past of the drive; the model stays affine in u(k)."""

    kind: ClassVar[str]

    @property
    def size(self) -> int:
        """Number of regressors."""
        ...

    @property
    def scales(self) -> tuple[float, ...]:
        """Typical magnitude of each regressor: the learner divides by it."""
        ...

    def describe(self) -> str:
        """One line for people: the shape parameters with units."""
        ...

    def regressors(self, drive: Drive) -> Floats:
        """(n, size) float64: phi_j(k) before u(k) acts, from the state that `_init` gives for u(0)."""
        ...

    def mirror(self, u_V: Floats32) -> Mirror:
        """The float32 reference, initialised by the inputs u_V (lanes,), as the generated `_init` does."""
        ...

    def constants(self) -> Mapping[str, Floats32]:
        """The float32 numbers that the C needs, by the name of their array in `<name>_params.h`."""
        ...

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, exact; includes "kind"."""
        ...

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Inverse of to_json. Raises KeyError, TypeError or ValueError on malformed data."""
        ...
