"""Unbroken runs of a record, and the command of their segment before them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.chain import Chain, Thinned

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
Samples = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class History:
    """The command of a segment before a run at selected samples: u_V, (k,); held: samples from each to the next.

    ages: (m + 1,) ends of intervals of ages in samples, counted back from the run. stand_for: (m,) the selected sample
    that stands for each interval. The selected samples contain every extreme that a hysteresis remembers, so the plays
    are exact.
    """

    u_V: Floats
    held: Samples
    ages: Samples
    stand_for: Rows

    def __len__(self) -> int:
        return len(self.u_V)

    @property
    def samples(self) -> int:
        """Samples of the segment before the run."""
        return int(self.held.sum())

    def slow_states(self, h: Floats, keep: Floats) -> Floats:
        """(m, s) states s(k+1) = keep s(k) + (1 - keep) h(k) at the start of the run, for h, (m, k).

        Before the segment h is constant.
        """
        left = np.exp(self.ages[:, None] * np.log(keep))
        return np.asarray(h[:, self.stand_for] @ (left[:-1] - left[1:]) + h[:, :1] * left[-1])


_NONE: Samples = np.zeros(0, dtype=np.int64)
NO_HISTORY = History(np.zeros(0), _NONE, _NONE, np.zeros(0, dtype=np.intp))


@dataclass(frozen=True, eq=False)
class Trace:
    """One unbroken run: u_V, y_um (n,), auxiliary channels, initial state of the plays (`Operator.columns`).

    history: the command of the same segment before the run. segment: samples of this segment; 0 for those of the run.
    stride: periods from each sample to the next; above 1, the signals are straight lines between fitted samples.
    share: (n,) share of the move from each sample to the next in the mean of the command between them; 1/2 for a line.
    """

    u_V: Floats
    y_um: Floats
    aux: Mapping[str, Floats]
    start: float = 0.0
    history: History = NO_HISTORY
    segment: int = 0
    stride: int = 1
    share: Floats = field(default_factory=lambda: np.full(1, 0.5))

    @property
    def whole(self) -> int:
        """Samples of the segment."""
        return self.segment or len(self.u_V)

    def time_s(self, Ts_s: float, samples: Rows | None = None) -> Floats:
        """(n,) time since the start of the segment; of some samples, (k,), if they are given."""
        at = np.arange(len(self.u_V)) if samples is None else samples
        return np.asarray(Ts_s * (self.history.samples + self.stride * at.astype(np.float64)))

    def held(self, h: Floats, chain: Chain, Ts_s: float) -> tuple[Floats, Chain]:
        """Input, (m, n), of the part of the chain behind the hysteresis for h, (m, n), and this part (`Thinned`)."""
        if self.stride == 1:
            return h, chain
        thinned = Thinned(chain.lag_s, chain.parts, chain.memory, stride=self.stride, Ts_s=Ts_s)
        return thinned.input(h), thinned


@dataclass(frozen=True, eq=False)
class Moments:
    """Some samples of a run, (k,): the argument of `Part.columns` where they depend on time alone (`Part.timed`)."""

    run: Trace
    samples: Rows

    @property
    def u_V(self) -> Floats:
        return self.run.u_V[self.samples]

    @property
    def aux(self) -> Mapping[str, Floats]:
        return {name: channel[self.samples] for name, channel in self.run.aux.items()}

    @property
    def whole(self) -> int:
        return self.run.whole

    @property
    def stride(self) -> int:
        return self.run.stride

    def time_s(self, Ts_s: float) -> Floats:
        """(k,) time since the start of the segment."""
        return self.run.time_s(Ts_s, self.samples)
