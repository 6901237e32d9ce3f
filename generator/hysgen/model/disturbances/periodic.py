"""Periodic: a disturbance at fixed frequencies (mains, floor, a fan), independent of the input.

    phi = cos(2 pi f_j Ts n),  sin(2 pi f_j Ts n)                 n: sample since time 0 (model), since _init (C)

The two weights of a frequency determine amplitude and phase. The C counts the phase as a 64-bit fraction of a turn: the
frequency error is below 2^-65 of the sampling frequency, amplitude and phase have no drift, and the sine is a
polynomial of the upper 32 bits (`cosine_sine`). A phasor rotated by float32 factors would have a phase error of
0.01 rad after 1e8 samples and would have to be renormalised.
The phase at the start of the DSP is unknown: the learner estimates it, or the caller writes the phase words of the
struct.

Cosine and sine of a 32-bit phase in float32: quadrant by integers, then polynomials.

    phase = quadrant * 2^30 + rest,   r = rest / 2^30 in [-1/2, 1/2)             r = 1 is a quarter of a turn
    sin(pi r / 2) = r ((s_0 + s_1 z) + z^2 (s_2 + s_3 z)),   z = r^2
    cos(pi r / 2) = 1 + z ((c_0 + c_1 z) + z^2 (c_2 + c_3 z))

Worst error against the exact functions, over all phases distinguished by the 23 bits of r: 1.9e-7, of which 1.0e-7 is
the quantisation of r. r is exact: its bits become the significand of a float in [1, 2), minus 1.5.
Coefficients: Chebyshev interpolation in r^2, rounded; tests/model/test_periodic.py computes them again.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.model.disturbances.base import Bits, Drive, Floats, Floats32, Mirror, Term, TermBox
from hysgen.model.part import Extent, RunSignals, ShapeParameter
from hysgen.model.structs import Member, Quantity
from hysgen.record.series import turning_rows

SINE: Final = tuple(np.float32(s) for s in (1.57079637, -0.64596349, 0.0796802193, -0.00460214913))
COSINE: Final = tuple(np.float32(c) for c in (-1.23370051, 0.253669411, -0.0208615288, 0.000906739908))
# Half a quadrant, so that the quadrant is the nearest one, and half a step of r, so that r is rounded and not cut.
NEAREST: Final = np.uint32(0x20000040)
FACTS: Final = {"sine": SINE, "cosine": COSINE, "nearest": f"0x{int(NEAREST):08x}"}

_ONE, _ONE_AND_A_HALF = np.float32(1.0), np.float32(1.5)
_REST, _DROPPED_BITS, _ONE_BITS = np.uint32(0x3FFFFFFF), np.uint32(7), np.uint32(0x3F800000)


def cosine_sine(phase: Bits) -> tuple[Floats32, Floats32]:
    """cos and sin of 2 pi phase / 2^32 over lanes, in the generated C's order."""
    shifted = phase + NEAREST
    quadrant = shifted >> np.uint32(30)
    r = (((shifted & _REST) >> _DROPPED_BITS) | _ONE_BITS).view(np.float32) - _ONE_AND_A_HALF
    z = r * r
    zz = z * z
    sine = r * ((SINE[0] + SINE[1] * z) + (SINE[2] + SINE[3] * z) * zz)
    cosine = _ONE + z * ((COSINE[0] + COSINE[1] * z) + (COSINE[2] + COSINE[3] * z) * zz)
    odd = np.uint32(0) - (quadrant & np.uint32(1))
    s, c = sine.view(np.uint32), cosine.view(np.uint32)
    swap = (s ^ c) & odd
    c_sign = ((quadrant + np.uint32(1)) & np.uint32(2)) << np.uint32(30)
    s_sign = (quadrant & np.uint32(2)) << np.uint32(30)
    return ((c ^ swap) ^ c_sign).view(np.float32), ((s ^ swap) ^ s_sign).view(np.float32)


BLOCK = 512

FEWEST_PERIODS = 4.0
"""Least periods of a line in a record: one per quarter, whose phases are compared. A slower one may be a drift."""

LINE = ShapeParameter(
    "f_Hz", "Hz", lambda e: (FEWEST_PERIODS / e.span_s, 0.5 / e.Ts_s), step=lambda e: 1e-3 / e.span_s, order=3.0
)

SMALLEST_SWING = 0.01
"""Least swing between two turning points of the command, as a share of its range."""

SAME_PHASE = 0.9
"""Mean of exp(i phase) for phases that are evenly spread over a quarter of a period: sinc(1/4)."""


@dataclass(frozen=True)
class Periodic(Term):
    """Frequencies `f_Hz`, (m,) positive and rising. Raises ValueError otherwise."""

    kind: ClassVar[str] = "periodic"
    cause: ClassVar[str] = "periodic"
    place: ClassVar[int] = 80
    timed: ClassVar[bool] = True
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "turn_high": Quantity("upper word of the turns per sample", "2^-32"),
        "turn_low": Quantity("lower word of the turns per sample", "2^-64"),
    }
    parts: ClassVar[Mapping[str, Mapping[str, Any]]] = MappingProxyType({"sine": FACTS})
    foreseen: ClassVar[bool] = True
    f_Hz: tuple[float, ...]

    def __post_init__(self) -> None:
        f = np.asarray(self.f_Hz, dtype=np.float64)
        if f.size == 0 or not np.isfinite(f).all() or f[0] <= 0 or (np.diff(f) < 0).any():
            raise ValueError("f_Hz must be positive and rising")

    @property
    def size(self) -> int:
        return 2 * len(self.f_Hz)

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        return tuple((f"periodic.{i}.f_Hz", LINE) for i, _ in enumerate(self.f_Hz))

    @property
    def values(self) -> tuple[float, ...]:
        return self.f_Hz

    def with_values(self, values: Sequence[float]) -> Self:
        return type(self)(tuple(sorted(values)))

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        # As the harmonics of the command have one phase at all of its maxima.
        at_s = np.concatenate([run.time_s(Ts_s)[_maxima(run)] for run in runs])
        return not any(same_phase(line_Hz, at_s) for line_Hz in self.f_Hz)

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        t_s = run.time_s(extent.Ts_s)
        return [wave(2 * np.pi * line_Hz * t_s) for line_Hz in self.f_Hz for wave in (np.cos, np.sin)]

    def describe(self) -> str:
        return "periodic disturbance at " + ", ".join(f"{f:.6g}" for f in self.f_Hz) + " Hz"

    def regressors(self, drive: Drive) -> Floats:
        """(n, 2 m) cosine and sine of each frequency, phase 0 at absolute time 0."""
        samples = drive.u_V.size
        # exp(i w (n + r)) = exp(i w n) exp(i w r): one complex product per sample instead of a cosine and a sine.
        block = _phasors(self.f_Hz, drive.Ts_s, np.arange(BLOCK))
        starts = _phasors(self.f_Hz, drive.Ts_s, drive.first + np.arange(0, samples, BLOCK))
        phasors = (starts[:, None, :] * block[None, :, :]).reshape(-1, len(self.f_Hz))[:samples]
        return np.ascontiguousarray(phasors).view(np.float64)

    def burn_in(self, drive: Drive) -> int:
        return 0

    def box(self, Ts_s: float) -> TermBox:
        """The phases are integers and may have any value; |phi| <= 1.001, for cosine and sine are polynomials."""
        return TermBox({}, (1.001,) * self.size)

    def members(self) -> tuple[Member, ...]:
        lines = (len(self.f_Hz),)
        return (
            Member("phase", "uint32_t", "upper word of the phase", lines, unit="turns / 2^32"),
            Member("phase_low", "uint32_t", "lower word of the phase", lines, unit="turns / 2^64"),
        )

    def mirror(self, lanes: int, Ts_s: float) -> PhaseMirror:
        constants = self.constants(Ts_s)
        return PhaseMirror(self, constants["turn_high"], constants["turn_low"], lanes)

    def constants(self, Ts_s: float) -> Mapping[str, Bits]:
        """Turns per sample in units of 2^-32 and 2^-64.

        Raises ModelError if a frequency lies beyond half the sampling frequency.
        """
        turns = [round(Fraction(f) * Fraction(Ts_s) * 2**64) for f in self.f_Hz]
        if max(turns) >= 2**63:
            raise ModelError(
                f"periodic: {self.f_Hz[-1]:.6g} Hz lies beyond half the sampling frequency, {0.5 / Ts_s:.6g} Hz; "
                "sample faster or take it out"
            )
        return {
            "turn_high": np.array([turn >> 32 for turn in turns], dtype=np.uint32),
            "turn_low": np.array([turn & 0xFFFFFFFF for turn in turns], dtype=np.uint32),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Mains and a harmonic."""
        mains_Hz = float(rng.uniform(49.0, 51.0))
        return (cls((mains_Hz, 3.0 * mains_Hz)),)


def same_phase(line_Hz: float, at_s: Floats) -> bool:
    """Whether a line has the same phase at all times at_s: |mean of exp(i phase)| > SAME_PHASE."""
    return len(at_s) > 1 and bool(abs(np.exp(2j * np.pi * line_Hz * at_s).mean()) > SAME_PHASE)


@functools.lru_cache(maxsize=8)
def _maxima(run: RunSignals) -> NDArray[np.intp]:
    """Every second turning point of the command of a run, as rows; each score of a line asks for them."""
    return turning_rows(run.u_V, SMALLEST_SWING * float(np.ptp(run.u_V)))[::2]


def _phasors(f_Hz: tuple[float, ...], Ts_s: float, n: NDArray[np.int64]) -> NDArray[np.complex128]:
    """exp(2 pi i f_j Ts n), (n, m); whole turns are subtracted before the angle is rounded."""
    turns = np.asarray(f_Hz) * Ts_s * n[:, None]
    return np.asarray(np.exp(2j * np.pi * (turns - np.floor(turns))))


class PhaseMirror(Mirror):
    """64-bit phases over lanes, in two words."""

    def __init__(self, term: Periodic, turn_high: Bits, turn_low: Bits, lanes: int) -> None:
        self.members = term.members()
        self._turns = list(zip(turn_high, turn_low, strict=True))
        self.phase: list[Bits] = [np.zeros(lanes, dtype=np.uint32) for _ in self._turns]
        self.phase_low: list[Bits] = [np.zeros(lanes, dtype=np.uint32) for _ in self._turns]

    def regressors(self) -> list[Floats32]:
        return [part for phase in self.phase for part in cosine_sine(phase)]

    def regressors_ahead(self, samples: int) -> list[Floats32]:
        """phi_j(k + samples), its phase rounded down by less than samples / 2^32 of a turn."""
        turns = (turn_high * np.uint32(samples) for turn_high, _ in self._turns)
        ahead = (phase + turn for phase, turn in zip(self.phase, turns, strict=True))
        return [part for phase in ahead for part in cosine_sine(phase)]

    def advance(self) -> None:
        for j, (turn_high, turn_low) in enumerate(self._turns):
            low = self.phase_low[j] + turn_low
            carry = (low < turn_low).astype(np.uint32)
            self.phase[j], self.phase_low[j] = (self.phase[j] + turn_high) + carry, low
