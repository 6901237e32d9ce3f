"""The proved bounds of a step: rules (`rounding`), path (`path_rounding`), what is added (`term_rounding`)."""

import contextlib
from dataclasses import dataclass

import numpy as np

from hysgen.errors import ModelError
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learnt_banks import bank_box, committed_gain
from hysgen.float32.reference import rounding
from hysgen.float32.reference.path_rounding import w_error
from hysgen.float32.reference.term_rounding import SLACK, correction_error, extra_error
from hysgen.model.model import Model


@dataclass(frozen=True)
class ProvedErrors:
    """Proved bounds of one step from any state.

    predict_um: of y(k+1) for every y and u in their ranges. path: part of w in it, in its unit. inverse_V: of the
    inverse's u(k) without responses of the stage. inverse_um: with them, of y(k+1) in real arithmetic against its
    reference, unless a limit acts, has led a mode astray, or the C says that the path is missed; behind a delay of
    a fraction, for the voltage that it wants at the stage. correct_um: of the correction of the feedback.
    any_bank_um: of y(k+1) with any bank that the learner may commit; any_bank_inverse_V: of u(k), as inverse_V.
    """

    predict_um: float
    path: float
    inverse_V: float | None
    inverse_um: float | None
    correct_um: float | None
    any_bank_um: float | None
    any_bank_inverse_V: float | None


def proved_errors(model: Model, *, inverse: bool) -> ProvedErrors | None:
    """The bounds of `model`; None of a part of your own, or where there is no bound.

    The box of the inverse reaches beyond the range of w, where its limits act.
    """
    numbers, path = coefficients(model), w_error(model)
    extra = extra_error(model, corrected=True)
    asked = extra_error(model, corrected=False) if inverse else None
    bounded = path < np.inf and (extra is None or extra.error_um < np.inf)
    predict = rounding.worst(model, path, extra) if bounded else np.inf
    if not predict < SLACK * max(abs(model.grid.y_min_um), abs(model.grid.y_max_um)):
        return None
    bounds = [np.inf, np.inf]
    if inverse and all(block.solves(model.Ts_s) for block in model.blocks):
        # The C compares the w that its path reaches with the one it wants.
        missed = path + 1.001 * float(numbers.w_tolerance) if model.responds else None
        bounds[int(model.responds)] = rounding.worst(model, 0.0, asked, inverse=True, missed=missed)
    learnt = [np.inf, np.inf]
    if model.learner is not None:
        with contextlib.suppress(ModelError):  # without a gain above its rounding there is no bound of any bank
            banks = learnt_banks(model)
            learnt[0] = rounding.worst(model, path, extra, banks=banks)
            if inverse and not model.responds:
                learnt[1] = rounding.worst(model, 0.0, asked, inverse=True, banks=banks)
    stated = (bound if np.isfinite(bound) else None for bound in (*bounds, correction_error(model) or np.inf, *learnt))
    return ProvedErrors(predict, path, *stated)


def learnt_banks(model: Model) -> rounding.Banks:
    """The banks that the learner may commit. Raises ModelError as `committed_gain` does."""
    box, rules, gain = bank_box(model), range(model.grid.rules), committed_gain(model)
    slope, offset, of_w = (
        np.array([box[f"{group}[{rule}]"].magnitude for rule in rules]) for group in ("slope", "offset", "gain")
    )
    return rounding.Banks(slope, offset, of_w, (gain.low, gain.high))
