"""What a cause adds to the Takagi-Sugeno model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.inputs import InputBlock
from hysgen.terms import Term

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Extension:
    """What a cause adds to the model: a term, an input block, or how the fit and the learner treat samples.

    trust: (n,) how much each row of the whole record counts, or None. ramp_um_per_s: drift taken out before the fit,
    because a bias state follows it. gain_per_s: change of the gain around zero_um taken out before the fit, because the
    learner follows it by forgetting over forgetting_s.
    gate: the learner rejects what stands off its prediction.
    """

    term: Term | None = None
    block: InputBlock | None = None
    trust: Floats | None = None
    ramp_um_per_s: float = 0.0
    gain_per_s: float = 0.0
    zero_um: float = 0.0
    forgetting_s: float | None = None
    gate: bool = False
