"""Difference between the float32 reference and real arithmetic in one step: its proved bound, and the largest found.

The bound is put together from that of rules (`rounding`), path (`path_rounding`) and what is added (`term_rounding`).
Found is, over the whole range:

    predict    f32(y, u) minus sum_l p_l(y) (q_l1 y + q_l2 u + q_l3) + sum_j theta_j phi_j in float64
    inverse    u of Eq. (11) in float32 minus u in float64, for y(k+1) that an input in range reaches
    round trip y(k+1) in float64 of what the float32 inverse finds, minus the reference, where no limit acts

Both models get the same float32 inputs and the same states of terms and path, those of the float32 mirrors in a random
run; the difference is that of one step's arithmetic. With responses of the stage (hysteresis, creep, modes), w is in
place of u:

    path       w of the float32 path minus w in float64 (`path_rounding.real_w`), from the float32 state

Half the lanes drive a mode along its velocity, which brings it to its largest swing.

`python benchmarks/accuracy.py` prints the figures.
"""

import contextlib
import copy
import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import bank_box, committed_gain
from hysgen.float32.reference import rounding
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.path_rounding import real_w, traced, w_error
from hysgen.float32.reference.term_rounding import SLACK, correction_error, extra_error, real_correction, real_extra
from hysgen.machine.reproducible import drawn, product
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import PhaseMirror
from hysgen.model.feedback import FeedbackMirror
from hysgen.model.float32_arithmetic import Floats32, flushed
from hysgen.model.model import Model
from hysgen.model.path.chain import ChainMirror, Flags
from hysgen.model.path.modes_mirror import ModesMirror
from hysgen.model.regression import memberships

Floats = NDArray[np.float64]
Aux = Mapping[str, Floats]

LANES: Final = 1 << 16
WARM_UP: Final = 20
RUN: Final = 128
"""Samples of a run through a path, at least."""


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


@dataclass(frozen=True)
class Accuracy:
    """Largest absolute differences over `samples` pairs (y, u); inverse and round trip are 0 without an inverse.

    path: difference of w, in its unit; 0 without a path, or if it is not `traced`. correct_um: of the correction of the
    feedback, 0 without. These are found; proved: bounds.
    """

    samples: int
    predict_um: float
    inverse_V: float
    predict_of_inverse_um: float
    path: float = 0.0
    correct_um: float = 0.0
    proved: ProvedErrors | None = None


def accuracy(model: Model, samples: int, *, inverse: bool = True, seed: int = 1) -> Accuracy:
    """The differences over pairs (y, u): half on a grid of both ranges, limits included, half uniformly distributed."""
    bare, worst, path = model.behind_path, np.zeros(3), 0.0
    sweeps = [(bare, LANES)] + [(model, min(LANES, max(samples // RUN, 1)))] * bool(model.blocks)
    for swept, lanes in sweeps:
        run = _Run(swept)
        solves = inverse and (swept is model or not model.responds)
        for y, u in _pairs(swept, samples, seed, lanes):
            worst = np.maximum(worst, _step_errors(bare, _warm(bare, y.size, seed), run, y, u, solves))
        path = run.path
    bounds = proved_errors(model, inverse=inverse)
    predict_um, inverse_V, again_um = worst.tolist()
    return Accuracy(samples, predict_um, inverse_V, again_um, path, _correction(model, samples, seed), bounds)


class _Run:
    """A run through the path of a model over lanes; path: its largest error."""

    def __init__(self, model: Model) -> None:
        self._model, self._traced, self.path = model, traced(model), 0.0
        self._chain: ChainMirror | None = None
        self._solves = self._traced and all(block.solves(model.Ts_s) for block in model.blocks if block.responds)

    def step(self, u: Floats32) -> tuple[Floats32, Floats]:
        """w in float32, the input of the rules, and in real arithmetic, from the same state; (lanes,) each."""
        if not self._model.blocks:
            return u, u.astype(np.float64)
        if self._chain is None or self._chain.v_V.size != u.size:
            self._chain = Instance(self._model, np.full(u.size, np.float32(self._model.grid.y_min_um)), u).inputs
        self._before = copy.deepcopy(self._chain)
        for modes in (mirror for mirror in self._chain.blocks if isinstance(mirror, ModesMirror)):
            lane = np.arange(1, u.size, 2)
            rises = np.array(modes.velocity)[lane // 2 % len(modes.velocity), lane] > 0.0
            u = u.copy()
            u[lane] = np.where(rises, np.float32(self._model.u_max_V), np.float32(self._model.u_min_V))
        w = self._chain.apply(u)
        exact = real_w(self._model, self._before, u) if self._traced else w.astype(np.float64)
        self.path = max(self.path, float(np.abs(w - exact).max()))
        return w, exact

    def inverted(self, w: Floats32) -> tuple[Floats, Flags]:
        """The w that the inverse of the path reaches instead, from the state before `step`, and where no limit acts."""
        if not self._model.responds:
            return w.astype(np.float64), np.full(w.shape, True)
        chain, before = copy.deepcopy(self._before), self._before
        inverted = chain.invert(w)
        free = ~(inverted.unreachable | (inverted.astray != 0.0))
        if not self._solves:
            return inverted.w.astype(np.float64), free
        v = before.v_V
        if any(
            block.interpolates for block in self._model.blocks
        ):  # the inverse solves for the sample after the one that is stored
            for block, mirror in zip(self._model.blocks, before.blocks, strict=True):
                v = flushed(mirror.apply(v)) if block.responds else v
        return real_w(self._model, before, chain.v_V, stage=True), free


def _step_errors(
    model: Model, warm: tuple[Instance, Aux], run: _Run, y: Floats32, u: Floats32, inverse: bool
) -> Floats:
    """(3,) the largest difference over the lanes, in the order of the fields of `Accuracy`; model: behind the path."""
    w, exact_w = run.step(u)
    instance, aux = warm
    rules, gain = _affine(model, y)
    innovation = model.grid.clamp(y.astype(np.float64)) - instance.y_um
    exact_base = rules + real_extra(model, instance.terms, innovation, aux)
    forward, backward = copy.deepcopy(instance), copy.deepcopy(instance)
    y_next = forward.predict(y, w)
    predicted = np.abs(y_next - (exact_base + gain * exact_w)).max()
    if not inverse:
        return np.array([predicted, 0.0, 0.0])
    # The inverse does not correct the terms by the innovation, so its y(k+1) differs from that of predict.
    base = rules + real_extra(model, instance.terms, None, aux)
    numbers = instance.numbers
    wanted = np.clip((base + gain * w).astype(np.float32), numbers.reference_min_um, numbers.reference_max_um)
    w_back = backward.inverse(y, wanted)
    exact_back = np.clip((wanted - base) / gain, float(numbers.u_min_V), float(numbers.u_max_V))
    inside = (w_back > numbers.u_min_V) & (w_back < numbers.u_max_V)
    inside &= (wanted > numbers.reference_min_um) & (wanted < numbers.reference_max_um)
    reached, free = run.inverted(w_back)
    missed = np.abs((base + gain * reached - wanted)[inside & free]).max(initial=0.0)
    return np.array([predicted, np.abs(w_back - exact_back).max(), missed])


def _correction(model: Model, samples: int, seed: int) -> float:
    """Largest difference of the feedback's correction over `samples` residuals in a run; 0 without feedback."""
    if model.feedback is None:
        return 0.0
    lanes, reach = min(LANES, max(samples // RUN, 1)), float(coefficients(model).reach_um)
    rng, mirror = np.random.default_rng(seed), FeedbackMirror(model.feedback, lanes, model.Ts_s)
    largest, free = 0.0, np.zeros(lanes, np.uint32)
    for _ in range(0, samples, lanes):
        residual = drawn(rng, -reach, reach, lanes).astype(np.float32)
        exact = real_correction(model.feedback, mirror, residual.astype(np.float64), model.Ts_s)
        largest = max(largest, float(np.abs(mirror.apply(residual, free, free) - exact).max()))
    return largest


def beyond_references(model: Model) -> float:
    """Largest share of the input's range by which a step f(y, w) passes the references of the inverse."""
    numbers, w = coefficients(model), np.array([[model.w_range.low], [model.w_range.high]])
    base, gain = _affine(model, np.linspace(numbers.y_min_um, numbers.y_max_um, LANES // RUN).astype(np.float32))
    y_um = base + gain * w
    beyond_um = y_um - np.clip(y_um, numbers.reference_min_um, numbers.reference_max_um)
    return float(np.abs(beyond_um / gain).max() / (model.w_range.high - model.w_range.low))


def _affine(model: Model, y: Floats32) -> tuple[Floats, Floats]:
    """f(y, 0) [um] without disturbances and b(y) [um/V] in float64, (lanes,) each."""
    y64 = y.astype(np.float64)
    p = memberships(y64, model.grid)
    q1, q2, q3 = model.consequents.T
    return product(p, q1) * model.grid.clamp(y64) + product(p, q3), product(p, q2)


def _pairs(model: Model, samples: int, seed: int, lanes: int) -> Iterator[tuple[Floats32, Floats32]]:
    rng, side = np.random.default_rng(seed), max(2, round((samples / 2) ** 0.5))
    ranges = (model.grid.y_min_um, model.grid.y_max_um), (model.u_min_V, model.u_max_V)
    for begin in range(0, samples, lanes):
        place = np.arange(begin, min(begin + lanes, samples))
        shares = [
            np.where(place < side * side, part / (side - 1.0), drawn(rng, 0.0, 1.0, place.size))
            for part in (place % side, place // side)
        ]
        pairs = zip(shares, np.array(ranges, dtype=np.float32), strict=True)
        y, u = (low + share * (high - low) for share, (low, high) in pairs)
        yield y.astype(np.float32), u.astype(np.float32)


@functools.lru_cache(maxsize=1)
def _warm(model: Model, lanes: int, seed: int) -> tuple[Instance, Aux]:
    """An instance whose lanes have the term states of independent random runs of WARM_UP samples; its channels."""
    rng, aux = np.random.default_rng(seed + 1), dict[str, Floats32]()
    instance = Instance(model, np.full(lanes, np.float32(model.grid.y_min_um)), np.zeros(lanes, dtype=np.float32))
    ranges = (model.grid.y_min_um, model.grid.y_max_um), (model.u_min_V, model.u_max_V)
    for _ in range(WARM_UP if model.terms else 0):
        for term in (term for term in model.terms if isinstance(term, Coupling)):
            for name, (low, high) in term.ranges.items():
                aux[name] = drawn(rng, 1.1 * low - 0.1 * high, 1.1 * high - 0.1 * low, lanes).astype(np.float32)
        instance.aux([aux[name] for name in instance.channels])
        y, u = (drawn(rng, low, high, lanes).astype(np.float32) for low, high in ranges)
        instance.predict(y, u)
    for mirror in (mirror for mirror in instance.terms if isinstance(mirror, PhaseMirror)):
        for words in (mirror.phase, mirror.phase_low):
            words[:] = [rng.integers(0, 2**32, lanes, dtype=np.uint32) for _ in words]
    return instance, {name: values.astype(np.float64) for name, values in aux.items()}
