"""What a cause adds to the Takagi-Sugeno model."""

from __future__ import annotations

import abc
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.model.model import Model
from hysgen.model.path import InputBlock
from hysgen.model.terms import Term

Floats = NDArray[np.float64]


class Correction(abc.ABC):
    """A slow change that is taken out of the displacement before a fit; frozen and comparable."""

    @abc.abstractmethod
    def removed(self, y_um: Floats, t_s: Floats) -> Floats:
        """(n,) displacement without the change; t_s: (n,) time since the start of the segment."""

    def online_term(self, model: Model, span_s: float) -> Term | None:
        """The term with weight 1 that follows the change in operation. span_s: length of the record."""
        return None


@dataclass(frozen=True, eq=False)
class Extension:
    """What a cause adds to the model: a term, an input block, or how the fit and the learner treat samples.

    trust: (m,) weight of each row in the fit, for the first m rows of the record, or None for 1 throughout.
    correction: slow change that is taken out of the displacement before the fit.
    forgetting_s: memory of the learner, so that it follows a change of the gain.
    gate: the learner rejects samples that are far from its prediction.
    """

    term: Term | None = None
    block: InputBlock | None = None
    trust: Floats | None = None
    correction: Correction | None = None
    forgetting_s: float | None = None
    gate: bool = False

    @property
    def content(self) -> Hashable:
        """Key of a cache of fits: equal for extensions that give the same models."""
        trust = None if self.trust is None else self.trust.tobytes()
        return (self.term, self.block, trust, self.correction, self.learns)

    @property
    def learns(self) -> bool:
        """Whether the extension is a setting of the learner, so that the model needs one."""
        return self.gate or self.forgetting_s is not None
