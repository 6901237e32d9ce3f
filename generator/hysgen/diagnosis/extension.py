"""What a cause adds to the Takagi-Sugeno model."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.model.path import InputBlock
from hysgen.model.terms import Term

Floats = NDArray[np.float64]


def trend_course(t_s: Floats | float, since_s: float | None) -> Floats:
    """Course of a drift of unit size at time t: t, or log10(1 + t / since) if it slows down."""
    return np.asarray(t_s, dtype=np.float64) if since_s is None else np.log10(1.0 + np.asarray(t_s) / since_s)


@dataclass(frozen=True)
class Trend:
    """A drift over a segment: size_um times `trend_course`, i.e. per second, or per decade if it slows down."""

    size_um: float
    since_s: float | None = None

    def at(self, t_s: Floats) -> Floats:
        """(n,) um at times t_s after the start of a segment."""
        return self.size_um * trend_course(t_s, self.since_s)


@dataclass(frozen=True, eq=False)
class Extension:
    """What a cause adds to the model: a term, an input block, or how the fit and the learner treat samples.

    trust: (n,) how much each row of the whole record counts, or None. drift: taken out before the fit,
    because a bias state follows it. gain_per_s: change of the gain around zero_um taken out before the fit, because the
    learner follows it by forgetting over forgetting_s.
    gate: the learner rejects what stands off its prediction.
    """

    term: Term | None = None
    block: InputBlock | None = None
    trust: Floats | None = None
    drift: Trend | None = None
    gain_per_s: float = 0.0
    zero_um: float = 0.0
    forgetting_s: float | None = None
    gate: bool = False

    @property
    def content(self) -> Hashable:
        """What a fit with it depends on: the same for extensions that make the same models."""
        trust = None if self.trust is None else self.trust.tobytes()
        return (self.term, self.block, trust, self.drift, self.gain_per_s, self.zero_um, self.learns)

    @property
    def learns(self) -> bool:
        """Whether the extension is a setting of the learner, so that the model needs one."""
        return self.gate or self.forgetting_s is not None
