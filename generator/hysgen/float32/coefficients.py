"""The float32 numbers of a model and of its `_commit`, read by the generated C and by its NumPy reference.

Dense layout, up to 12 rules. With h the distance of the centres, t = (y - middle)/h, r = exp(t) = 2^(t log2 e) and
l' = l - (L-1)/2, the firing strength of rule l is
    p_l proportional to w_l r^l,   w_l = exp(-l'^2 / 2)
The bank holds the consequents multiplied by w_l, so that the sums over the rules are polynomials in r.

Windowed layout, above 12 rules. With n the nearest centre and t = (y - c_n)/h in [-1/2, 1/2], r as above, the firing
strength of rule n + j is
    p_{n+j} proportional to w_j r^(j+5),   w_j = exp(-j^2 / 2),   j = -5 .. 5
The tables are padded by 5 phantom rules of weight 0 at either end. The rules outside the window have less than 3e-7 of
the sum of all firing strengths.

`_commit` bounds the gain b and the slope s of a shadow. With p_l' = dp_l/dy and so on, and v_l = q_l1 y + q_l2 u +
q_l3, at a check point y_g

    b = sum p_l q_l2,                 b' = sum p_l' q_l2
    s = sum p_l q_l1 + sum p_l' v_l,  s' = 2 sum p_l' q_l1 + sum p_l'' v_l        s = df/dy, affine in u

and by Taylor's theorem anywhere within half a cell, |y - y_g| <= h,

    |b(y) - b| <= h |b'| + h^2/2 C2 R(q2),    |s(y)| <= |s| + h |s'| + h^2/2 (3 C2 R(q1) + C3 R(v)),

C2 >= sum |p_l''| and C3 >= sum |p_l'''| over the range, R(g) = (max_l g_l - min_l g_l)/2. R(g) suffices in place of
max |g_l|, as the memberships sum to 1 and a number common to all rules changes no derivative. R(v) is convex in (y, u)
and so largest at a corner of the range. The cells cover the range, so limits that these bounds meet at every check
point hold at every displacement.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import Certificates
from hysgen.errors import CertificateError
from hysgen.machine.reproducible import exp, exponential, product, total
from hysgen.model.float32_arithmetic import LEAST
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.path.base import TOLERANCE

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

MOST_DENSE_RULES: Final = 12
# r = exp(t) is computed as 2^(t log2 e).
OCTAVES_PER_STEP: Final = 1.4426950408889634
WINDOW_REACH: Final = 5
WINDOW: Final = 2 * WINDOW_REACH + 1


@dataclass(frozen=True)
class Bank:
    """The C struct `<name>_bank_t`: w_l q_l1, w_l q_l3, w_l q_l2, (rows,) each, and the terms' weights theta, (T,)."""

    slope: Floats32
    offset: Floats32
    gain: Floats32
    weight: Floats32


@dataclass(frozen=True)
class Coefficients:
    """The float32 numbers of predict, simulate and inverse.

    strength: w of the layout, (L,) dense or (11,) windowed.
    present: (L + 10,) 1 for a rule, 0 for a phantom; empty in the dense layout.
    fold: (L,) factor of each rule's consequent in the bank; pad: number of phantoms before the first rule.
    origin_um: the middle of the centres (dense) or the lowest centre (windowed).
    per_step: log2(e)/h, octaves per um (dense), or 1/h, steps per um (windowed). octaves: log2(e).
    reference_min_um, reference_max_um: limits of y(k+1) in the inverse, the displacement range extended by its own
    width at either end.
    u_step_max_V: initial and largest limit of the change of the inverse's voltage, twice the range of u: it never acts.
    w_min, w_max: range of w, the input of the rules (`Model.w_range`); that of u without responses of the stage.
    w_tolerance: largest |w' - w| that the inverse leaves unflagged, TOLERANCE of that range.
    rest_um, rest_V: replacements of a non-finite initial displacement and input.
    """

    windowed: bool
    rules: int
    y_min_um: np.float32
    y_max_um: np.float32
    u_min_V: np.float32
    u_max_V: np.float32
    u_step_max_V: np.float32
    w_min: np.float32
    w_max: np.float32
    w_tolerance: np.float32
    reference_min_um: np.float32
    reference_max_um: np.float32
    rest_um: np.float32
    rest_V: np.float32
    origin_um: np.float32
    per_step: np.float32
    strength: Floats32
    present: Floats32
    fold: Floats32
    pad: int
    bank: Bank
    octaves: np.float32

    @property
    def reach_um(self) -> np.float32:
        """Width of the displacement range: the largest residual of a feedback."""
        return np.float32(self.y_max_um - self.y_min_um)

    @property
    def bank_rules(self) -> int:
        """Length of the bank's tables over the rules, phantoms included."""
        return self.rules + 2 * self.pad


def coefficients(model: Model) -> Coefficients:
    """The float32 numbers of `model`; q and w are rounded to float32 before their product, as in the C of a commit."""
    grid = model.grid
    windowed = grid.rules > MOST_DENSE_RULES
    away = np.arange(-WINDOW_REACH, WINDOW_REACH + 1) if windowed else np.arange(grid.rules) - (grid.rules - 1) / 2
    strength = np.array([exp(-0.5 * a * a) for a in away.tolist()]).astype(np.float32)
    pad = WINDOW_REACH if windowed else 0
    ones = np.ones(grid.rules, dtype=np.float32)
    fold = ones if windowed else strength
    span = grid.y_max_um - grid.y_min_um
    first, last = grid.ends_um
    w = model.w_range
    return Coefficients(
        windowed=windowed,
        rules=grid.rules,
        y_min_um=single(grid.y_min_um),
        y_max_um=single(grid.y_max_um),
        u_min_V=single(model.u_min_V),
        u_max_V=single(model.u_max_V),
        u_step_max_V=single(2.0 * (model.u_max_V - model.u_min_V)),
        w_min=single(w.low),
        w_max=single(w.high),
        w_tolerance=single(TOLERANCE * w.width),
        reference_min_um=single(grid.y_min_um - span),
        reference_max_um=single(grid.y_max_um + span),
        rest_um=single(0.5 * (grid.y_min_um + grid.y_max_um)),
        rest_V=single(min(max(0.0, model.u_min_V), model.u_max_V)),
        origin_um=single(first if windowed else 0.5 * (first + last)),
        per_step=single((1.0 if windowed else OCTAVES_PER_STEP) / grid.step_um),
        strength=strength,
        present=np.pad(ones, pad) if windowed else np.zeros(0, dtype=np.float32),
        fold=fold,
        pad=pad,
        bank=folded(singles(model.consequents), singles(model.weights), fold, pad),
        octaves=single(OCTAVES_PER_STEP),
    )


def folded(consequents: Floats32, weights: Floats32, fold: Floats32, pad: int) -> Bank:
    """The bank of consequents (L, 3) and weights (T,): w_l q_l in float32, with `pad` zeros at either end."""
    slope, gain, offset = (np.pad(fold * consequents[:, column], pad) for column in range(3))
    return Bank(slope=slope, offset=offset, gain=gain, weight=weights)


def single(value: float) -> np.float32:
    """`value` as float32; magnitudes below LEAST, which the float32 arithmetic flushes to zero, become zero."""
    return np.float32(0.0) if abs(value) < LEAST else np.float32(value)


def singles(values: Floats) -> Floats32:
    """`single` of every element."""
    return np.where(np.abs(values) < LEAST, 0.0, values).astype(np.float32)


POINTS: Final = (32, 64, 128, 256, 512)
"""Candidate numbers of check points; the first with a Taylor remainder of at most a quarter of the margin is chosen."""

SAFETY: Final = 1.01
"""Factor on C2 and C3, whose maxima are taken over a fine grid, and on the bounds, for the rounding in float32."""

FLOOR: Final = 0.5
"""(Least committed gain)/(least gain of the model)."""

GAIN_CEILING: Final = 4.0
"""(Largest committed gain)/(largest gain of the model)."""


@dataclass(frozen=True)
class CommitNumbers:
    """The numbers of one model's `_commit`.

    y_um: (G,) check points. table: (G, 3 L), rows p_l, p_l', p_l'' divided by the strengths w_l.
    unfold: (L,) 1/w_l. half_um: h. gain_remainder, slope_remainder_1, slope_remainder_3: h^2/2 times C2, 3 C2, C3.
    sign: sign of the gain b; gain_floor, gain_ceiling: limits of |b| [um/V]; slope_limit: limit of |df/dy|.
    """

    settings: LearnerSettings
    y_um: Floats32
    table: Floats32
    unfold: Floats32
    half_um: np.float32
    gain_remainder: np.float32
    slope_remainder_1: np.float32
    slope_remainder_3: np.float32
    sign: np.float32
    gain_floor: np.float32
    gain_ceiling: np.float32
    slope_limit: np.float32

    @property
    def points(self) -> int:
        """Number of check points G."""
        return self.y_um.size

    @property
    def trial(self) -> int:
        """Number of samples over which a shadow is compared with the parameters in use."""
        return self.settings.settle // 4


def commit_numbers(model: Model, numbers: Coefficients, certificates: Certificates) -> CommitNumbers:
    """The numbers of `model`'s `_commit`.

    Raises CertificateError, with place and value, if the parameters of the model itself violate a limit of the commit.
    """
    settings = model.learner
    assert settings is not None
    steepest = certificates.slope.bound
    limit = settings.slope_limit if settings.slope_limit is not None else 1.0 - (1.0 - steepest) / 8.0
    if steepest >= min(limit, 1.0):
        slope = certificates.slope
        raise CertificateError(
            f"{model.name}: learner: |df/dy| is {slope.value:.4g} at y = {slope.y_um:.4g} um, "
            f"{certificates.w_name} = {slope.w:.4g} {certificates.w_unit}, not below the limit {min(limit, 1.0):.4g} "
            "that commit keeps; restrict the range (generate --input-range), or fit again"
        )
    floor, ceiling = _gain_limits(model, certificates, settings)
    points, c2, c3 = _points(model, settings, limit - steepest)
    half = 0.5 * (model.grid.y_max_um - model.grid.y_min_um) / points
    y: Floats = model.grid.y_min_um + half * (2.0 * np.arange(points, dtype=np.float64) + 1.0)
    table = np.concatenate(membership_derivatives(y, model.grid)[:3], axis=1)
    return CommitNumbers(
        settings=settings,
        y_um=y.astype(np.float32),
        table=(table / np.tile(numbers.fold, 3)).astype(np.float32),
        unfold=(1.0 / numbers.fold.astype(np.float64)).astype(np.float32),
        half_um=np.float32(SAFETY * half),
        gain_remainder=np.float32(SAFETY * 0.5 * (half * half) * c2),
        slope_remainder_1=np.float32(SAFETY * 1.5 * (half * half) * c2),
        slope_remainder_3=np.float32(SAFETY * 0.5 * (half * half) * c3),
        sign=np.float32(math.copysign(1.0, certificates.gain_highest.value + certificates.gain_lowest.value)),
        gain_floor=np.float32(floor),
        gain_ceiling=np.float32(ceiling),
        slope_limit=np.float32(1.0 - SAFETY * (1.0 - limit)),
    )


def membership_derivatives(y_um: Floats, grid: Grid) -> tuple[Floats, Floats, Floats, Floats]:
    """p_l and its first three derivatives at displacements y_um, (n,): (n, L) each, in 1, 1/um, 1/um^2, 1/um^3.

    With o = l - m, m = sum l p_l, V = sum o^2 p_l and K = sum o^3 p_l:  h p' = p o,  h^2 p'' = p (o^2 - V),
    h^3 p''' = p (o^3 - 3 V o - K).
    """
    s = (y_um[:, None] - grid.ends_um[0]) / grid.step_um
    rule = np.arange(grid.rules, dtype=np.float64)
    p = exponential(-0.5 * (s - rule) * (s - rule))
    p = p / total(p)[:, None]
    o = rule - product(p, rule)[:, None]
    square, cube = o * o, o * o * o
    variance, skew = product(p, square)[:, None], product(p, cube)[:, None]
    h = grid.step_um
    return p, p * o / h, p * (square - variance) / (h * h), p * (cube - 3.0 * variance * o - skew) / (h * h * h)


def _points(model: Model, settings: LearnerSettings, margin: float) -> tuple[int, float, float]:
    """Number G of check points and bounds C2, C3, so that h^2/2 (3 C2 R(q1) + C3 R(v)) of the model <= `margin`/4.

    Raises CertificateError if no number in POINTS, or not the number in the settings, suffices.
    """
    grid = model.grid
    fine = np.linspace(grid.y_min_um, grid.y_max_um, 400 * grid.rules)
    _, _, second, third = membership_derivatives(fine, grid)
    c2, c3 = (SAFETY * float(total(np.abs(derivative)).max()) for derivative in (second, third))
    q1, q2, q3 = model.consequents.T
    w = model.w_range
    corners = [q1 * y + q2 * end + q3 for y in (grid.y_min_um, grid.y_max_um) for end in (w.low, w.high)]
    rest = 3.0 * c2 * 0.5 * np.ptp(q1) + c3 * 0.5 * max(float(np.ptp(v)) for v in corners)
    for points in POINTS if settings.points is None else (settings.points,):
        half = 0.5 * (grid.y_max_um - grid.y_min_um) / points
        if 0.5 * (half * half) * rest <= 0.25 * margin:
            return points, c2, c3
    raise CertificateError(
        f"{model.name}: learner: {points} check points are too far apart for a slope that comes within {margin:.2g} of "
        "its limit; fit a smoother model, restrict the range (generate --input-range), or allow more points"
    )


def _gain_limits(model: Model, certificates: Certificates, settings: LearnerSettings) -> tuple[float, float]:
    """Least and largest |b|.

    Raises CertificateError if the gain does not hold, or if the settings require a larger least gain than the model
    has.
    """
    ends, unit = [certificates.gain_lowest.bound, certificates.gain_highest.bound], f"um/{certificates.w_unit}"
    if not certificates.gain_holds:
        low = certificates.gain_lowest
        raise CertificateError(
            f"{model.name}: learner: the gain df/d{certificates.w_name} is {low.value:.4g} {unit} at "
            f"y = {low.y_um:.4g} um and does not stay away from zero, so no shadow could be committed; restrict the "
            "range (generate --displacement-range), or fit again"
        )
    weakest, strongest = sorted(abs(end) for end in ends)
    chosen = settings.gain_floor_um_per_V
    if chosen is not None and chosen >= weakest:
        raise CertificateError(
            f"{model.name}: learner: gain_floor_um_per_V {chosen:.4g} is not below the model's own {weakest:.4g} {unit}"
        )
    floor = FLOOR * weakest if chosen is None else chosen
    return floor, GAIN_CEILING * strongest
