"""Random models and records for the tests of the float64 world: seeded, and of every size that matters."""

from __future__ import annotations

from typing import Any

import numpy as np

from hysgen.model import Grid, Model
from hysgen.record import Record, Segment
from hysgen.terms import Term
from hysgen.terms.memory import Memory

TS_S = 2e-5


def random_model(seed: int, rules: int = 6, wild: float = 0.3, terms: tuple[Term, ...] = ()) -> Model:
    """A lag that fills 0.8 of its grid over 0..100 V, whose rules differ by `wild`.

    The terms' weights are random, about a tenth of the gain. wild 0.1 gives models with and without certificates; below
    0.03 most have them.
    """
    rng = np.random.default_rng(seed)
    y_min = float(rng.uniform(-100.0, 50.0))
    span = float(10.0 ** rng.uniform(-1.0, 1.5))
    grid = Grid(y_min, y_min + span, rules)
    slope = float(rng.uniform(0.8, 0.98))
    gain = (1.0 - slope) * 0.8 * span / 100.0
    differing = slope + 0.3 * wild * rng.normal(size=rules)
    gains = gain * (1.0 + wild * rng.normal(size=rules))
    offset = (1.0 - slope) * (y_min + 0.5 * span) - 50.0 * gains + 0.3 * wild * grid.step_um * rng.normal(size=rules)
    consequents = np.column_stack([differing, gains, offset - (differing - slope) * grid.centres_um])
    size = sum(term.size for term in terms)
    return Model("random", TS_S, grid, consequents, 0.0, 100.0, terms, 0.1 * gain * rng.normal(size=size))


def random_drive(samples: int, seed: int) -> Any:
    """(n,) voltages in 0..100 V: two sines whose amplitudes change, and steps."""
    rng = np.random.default_rng(seed)
    k = np.arange(samples)
    u = 50.0 + 30.0 * np.sin(0.011 * k) * np.sin(0.00071 * k + 1.0)
    u += 10.0 * np.repeat(rng.uniform(-1, 1, samples // 150 + 1), 150)[:samples]
    return np.clip(u, 0.0, 100.0)


def lag_record(samples: int = 4000, seed: int = 0, noise_um: float = 0.002, segments: int = 1) -> Record:
    """A nonlinear lag with play: smooth enough for a few rules, not one of them. 0..10 um at 50 kHz."""
    rng = np.random.default_rng(seed)
    parts = []
    for number in range(segments):
        u = random_drive(samples, seed + 17 * number)
        z = Memory.uniform(4, 25.0)
        play = play_sum(z, u)
        y = np.empty(samples)
        y[0] = 0.06 * u[0] + 0.01 * play[0]
        for k in range(samples - 1):
            target = 0.06 * u[k] + 0.01 * play[k] + 0.6 * np.sin(0.05 * u[k])
            y[k + 1] = y[k] + (0.03 + 0.002 * y[k]) * (target - y[k])
        parts.append(Segment(f"{number}", u, y + noise_um * rng.normal(size=samples)))
    return Record.from_segments(parts, TS_S, "lag")


def play_sum(term: Memory, u: Any) -> Any:
    """(n,) sum of the plays of a memory term, by the definition."""
    z = np.full(term.size, u[0])
    out = np.empty(u.size)
    r = np.asarray(term.thresholds_V)
    for k, value in enumerate(u):
        out[k] = z.sum()
        z = np.clip(z, value - r, value + r)
    return out
