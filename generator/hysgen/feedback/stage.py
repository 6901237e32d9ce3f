"""What a correction of the reference becomes: the stage behind the emitted inverse, for draws of what it may be.

    P(z) = g z^-latency prod_b [B_b'(z) / B_b(z)] (1 - a')/(z - a') (z - a)/(1 - a)

a' and B' are the lag and the blocks of the stage, a and B those of the model. A block that the inverse leaves out
stands alone; a delay is its preview in whole samples. The inverse takes hysteresis and rules at the level of the model,
so g = 1, but for the error of the local slope. Creep is slower than any loop and is left to g; saturation and slew are
limits, at which the integral stands still. States in the loop of a mode stand between springs (small amplitudes) and
nothing (large ones); modes that follow their amplitude (`softening`) are held at any one of it, under the own drive.
Other drives push the stage: they are no part of P.
"""

import dataclasses
import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # its parts are imported where they work
from numpy.typing import NDArray

from hysgen.certify.enclosure import slope
from hysgen.errors import ModelError
from hysgen.model.model import Model
from hysgen.model.path.base import StateSpace, inverted
from hysgen.model.path.loop import Loop
from hysgen.model.path.modes import LEAST_DAMPING, MOST_DAMPING, Modes
from hysgen.model.path.softening import ENDS, Softening

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

LOG2_DRAWS = 10
"""Binary logarithm of the number of draws: 1024 points of a Sobol sequence, the same on every machine."""

LATENCY = 1.0
"""Samples from reading to voltage by default: it is put out when the next sample begins."""

POINTS, WIDTHS, MOST_NEAR = 300, 5.0, 200
"""Frequencies from LOWEST to half the sampling rate, and widths of a mode, and most frequencies, about each mode."""

LOWEST = 1e-5
"""Lowest frequency as a share of the sampling rate: there the integral alone counts."""

RINGS, LEAST_SHARE = 0.3, 0.01
"""Damping ratio below which a pole rings, and share of the displacement from which on a mode counts."""

Ringing = Modes | Loop | Softening
"""Blocks that ring."""

UNVARIED = ("fall", "fall_quadrature", "seen", "seen_quadrature")
OF_MODES = ("f_Hz", "zeta", *UNVARIED, "share", "quadrature", "swing", "swing_quadrature")
"""Fields of a block that hold numbers of each mode."""

HELD = (ENDS[0], 0.5 * ENDS[1], ENDS[1])
"""Amplitudes at which modes that follow it are looked at."""


@dataclass(frozen=True)
class Uncertainty:
    """Half widths of what the stage may differ by from its model; relative, but for late, in samples.

    gain: of the local slope after a turn, where a model of a hysteresis is worst. frequency, damping, share: of every
    mode; temperature and load move a mode by about a hundredth. lag: of the time constant of the rules. late: delay.
    """

    gain: float = 0.15
    frequency: float = 0.01
    damping: float = 0.3
    share: float = 0.1
    lag: float = 0.1
    late: float = 0.25

    def __post_init__(self) -> None:
        for name, value in dataclasses.asdict(self).items():
            if not 0.0 <= value < (1.0 if name != "late" else math.inf):
                raise ModelError(
                    f"uncertainty: {name} = {value:g}; choose a share from 0 up to 1, of late samples from 0"
                )


def draws(model: Model) -> Floats:
    """(1024, d) numbers from -1 to 1: what every uncertain number of the stage differs by, in half widths."""
    alone = sum(_alone(block)[-1] + 1 for block in model.blocks if isinstance(block, Modes | Softening))
    return np.asarray(2.0 * scipy.stats.qmc.Sobol(4 + 3 * alone, scramble=False).random_base2(LOG2_DRAWS) - 1.0)


def _alone(block: Modes | Softening) -> list[int]:
    """To which of the modes that stand alone each one belongs: those nearer than their half widths move together.

    An identification takes several for one that is not quite linear; no reading tells them apart.
    """
    f, widths = np.array(block.f_Hz), np.array(block.f_Hz) * block.zeta
    return [0, *np.cumsum(np.diff(f) > widths[1:] + widths[:-1]).tolist()]


def modes_of(model: Model) -> list[tuple[float, float]]:
    """Frequency in Hz and damping ratio of every mode with LEAST_SHARE of the displacement or more, lowest first.

    A mode that follows its amplitude stands at each of HELD.
    """
    modes: list[tuple[float, float]] = []
    for block in model.blocks:
        if isinstance(block, Modes):
            rows = zip(block.f_Hz, block.zeta, block.residues(), strict=True)
            modes += [(f, zeta) for f, zeta, q in rows if abs(q) >= LEAST_SHARE]
        elif isinstance(block, Softening):
            counts = np.abs(block.of_drives[0][:, 0]) >= LEAST_SHARE
            modes += [(f, zeta) for s in HELD for f, zeta in np.transpose(block.natural(s))[counts].tolist()]
        modes += [(block.f_Hz, block.zeta)] if isinstance(block, Loop) else []
    return sorted(modes)


def inverse(model: Model) -> list[StateSpace]:
    """The factors of the emitted inverse but for its delay: of the blocks that it solves, and of the lag."""
    solved = [block for block in model.blocks if isinstance(block, Modes | Loop) and block.solves(model.Ts_s)]
    a = _pole(model)
    lag = (np.zeros((1, 1)), np.ones(1), np.array([-a / (1.0 - a)]), 1.0 / (1.0 - a))
    return [*(inverted(_space(block, model.Ts_s)) for block in solved), lag]


def stage(model: Model, unit: Floats, given: Uncertainty, samples: float) -> list[StateSpace]:
    """The factors of one draw, (d,), of the stage behind a delay; unit = 0 is the model itself."""
    gain, lag, late, spring, *rest = unit.tolist()
    varied = iter(np.reshape(rest, (-1, 3)))
    chain: list[StateSpace] = [(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0 + given.gain * gain)]
    for block in model.blocks:
        if isinstance(block, Modes | Softening):
            alone = _alone(block)
            block = _varied(block, np.array([next(varied) for _ in range(alone[-1] + 1)])[alone], given)
        if isinstance(block, Ringing):
            chain.append(_space(block, model.Ts_s, 0.5 + 0.5 * spring))
    a = _pole(model) ** (1.0 / (1.0 + given.lag * lag))
    chain.append((np.array([[a]]), np.array([1.0 - a]), np.ones(1), 0.0))
    return [*chain, _delayed(max(samples + given.late * late, 0.0))]


def _space(block: Ringing, Ts_s: float, share: float = 0.5) -> StateSpace:
    """share: of the springs, or of the amplitude."""
    if isinstance(block, Modes):
        return block.state_space(Ts_s)
    return block.held(share * ENDS[1], Ts_s) if isinstance(block, Softening) else _loop_space(block, share, Ts_s)


def lines(model: Model) -> list[tuple[float, float]]:
    """Frequency in Hz and damping ratio of what rings in P: poles of the inverse, or of blocks that it leaves out."""
    ringing: list[tuple[float, float]] = []
    for block in model.blocks:
        for share in (0.0, 1.0) if isinstance(block, Softening) else (0.5,):
            if isinstance(block, Ringing):
                space = _space(block, model.Ts_s, share)
                matrix = (inverted(space) if block.solves(model.Ts_s) else space)[0]
                poles = np.linalg.eigvals(matrix).astype(np.complex128)
                named = [natural(pole, model.Ts_s) for pole in poles[poles.imag > 0.0]]
                ringing += [(f_Hz, max(zeta, LEAST_DAMPING)) for f_Hz, zeta in named if zeta < RINGS]
    return sorted(ringing)


def frequencies(model: Model, given: Uncertainty) -> Floats:
    """Frequencies that resolve every mode wherever the uncertainty takes it, (n,), below half the sampling rate."""
    Ts_s = model.Ts_s
    parts = [np.geomspace(LOWEST / Ts_s, 0.499 / Ts_s, POINTS)]
    resolved: list[float] = []
    for zeta, f_Hz in sorted((zeta, f_Hz) for f_Hz, zeta in (*modes_of(model), *lines(model))):
        if any(abs(f_Hz - other) < zeta * f_Hz for other in resolved):
            continue
        resolved.append(f_Hz)
        sharp = zeta * max(1.0 - given.damping, 0.1)
        reach = given.frequency + given.share + WIDTHS * sharp
        parts.append(f_Hz * (1.0 + reach * np.linspace(-1.0, 1.0, min(math.ceil(4.0 * reach / sharp), MOST_NEAR))))
    # Near half the sampling rate, where zeros of sampled modes make the inverse ring.
    parts.append(0.5 / Ts_s * (1.0 - np.geomspace(1e-6, 0.1, POINTS // 5)))
    f = np.unique(np.concatenate(parts))
    return f[(f >= LOWEST / Ts_s) & (f < 0.5 / Ts_s)]


def natural(pole: complex, Ts_s: float) -> tuple[float, float]:
    """Frequency in Hz and damping ratio of a pole in z."""
    rate = np.log(pole) / Ts_s
    return float(abs(rate)) / (2.0 * math.pi), float(-rate.real / abs(rate))


def response(chain: Sequence[StateSpace], z: Complex) -> Complex:
    """Product of the responses D + C (z - A)^-1 B of the factors, at z, (n,)."""
    product = np.ones(z.shape, dtype=np.complex128)
    for A, B, C, D in chain:
        product *= D + np.linalg.solve(z[:, None, None] * np.eye(B.size) - A, B[:, None])[..., 0] @ C
    return product


def _delayed(samples: float) -> StateSpace:
    """Whole samples and linear interpolation between two of them."""
    whole = int(samples)
    taps = np.zeros(whole + 2)
    taps[whole:] = 1.0 + whole - samples, samples - whole
    return np.eye(whole + 1, k=-1), np.eye(whole + 1)[0], taps[1:], float(taps[0])


@functools.lru_cache(maxsize=8)
def _pole(model: Model) -> float:
    """df/dy in the middle of the ranges: the lag of the rules."""
    middle = 0.5 * np.array([[model.grid.y_min_um + model.grid.y_max_um], [model.w_range.low + model.w_range.high]])
    return min(max(float(slope(model, *middle)[0]), 1e-6), 1.0 - 1e-6)


def _varied(block: Modes | Softening, unit: Floats, given: Uncertainty) -> Modes | Softening:
    """The block with other frequencies, damping ratios and shares; unit: (m, 3)."""
    f = np.array(block.f_Hz) * (1.0 + given.frequency * unit[:, 0])
    zeta = np.clip(np.array(block.zeta) * (1.0 + given.damping * unit[:, 1]), LEAST_DAMPING, MOST_DAMPING)
    factors = {"f_Hz": f / block.f_Hz, "zeta": zeta / block.zeta} | dict.fromkeys(UNVARIED, np.ones(f.size))
    scale, changes = 1.0 + given.share * unit[:, 2], dict[str, Any]()
    if isinstance(block, Softening):
        # All of the displacement is of its modes: the static gain varies by `gain` alone.
        scale /= block.of_drives[0][:, 0].real @ scale
    for name in (name for name in OF_MODES if hasattr(block, name)):
        rows = np.reshape(getattr(block, name), (f.size, -1)) * factors.get(name, scale)[:, None]
        changes[name] = tuple(rows[np.argsort(f)].ravel().tolist())
    return dataclasses.replace(block, **changes)


def _loop_space(block: Loop, spring: float, Ts_s: float) -> StateSpace:
    """From w to the output of the block whose states are springs of this share of their slope; lag as in the block.

    x <- lam x + e spring (y + Re x), n times a sample, y a line between samples;   out = w + (x(k+1) - a x(k))/(1 - a)
    """
    step = complex(block.mode.steps(Ts_s / block.parts)[0])
    e = spring * np.array([sum(block.force), sum(block.quadrature)])
    turn = np.array([[1.0 - step.real, -step.imag], [step.imag, 1.0 - step.real]]) + np.outer(e, [1.0, 0.0])
    a = math.exp(-Ts_s / block.lag_s)
    # State: y(k) and x(k); y(k+1) = a y + (1 - a) w.
    A, B = np.zeros((3, 3)), np.zeros(3)
    A[0, 0], B[0] = a, 1.0 - a
    moved, of_y, of_next = np.eye(2), np.zeros(2), np.zeros(2)
    for i in range(block.parts):
        share = i / block.parts
        moved, of_y, of_next = turn @ moved, turn @ of_y + (1.0 - share) * e, turn @ of_next + share * e
    A[1:, 1:], A[1:, 0], B[1:] = moved, of_y + a * of_next, (1.0 - a) * of_next
    C = (A[1] - a * np.array([0.0, 1.0, 0.0])) / (1.0 - a)
    return A, B, C, 1.0 + B[1] / (1.0 - a)
