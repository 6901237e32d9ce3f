"""One scenario: a stage with hidden effects, how it is driven, and what of it has to be found.

Strengths, rates, ranges, noise and hysteresis are drawn from the seed. Nothing is drawn from the analysis.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.stage import BoucWen, Curve, Density, Noise, Preisach, Relays, Stage
from hysgen.studies.bank.excitation import POOR, good, poor, wandering

Floats = NDArray[np.float64]

EFFECTS = (
    "creep", "resonance", "delay", "saturation", "slew", "drift", "periodic", "aging", "outliers", "coupling",
)  # fmt: skip
JUDGED_TOO = ("constant", "saturation")
"""Refused where a person can measure again; here a stage may rest, and a mode ring beyond the converter."""

CATEGORIES = (*EFFECTS, "pair", "memory", "none", "unknown", "poor")
RATES_HZ = (200.0, 1000.0, 5000.0, 10e3, 50e3)


@dataclass(frozen=True, eq=False)
class Scenario:
    """A stage, its command and further channels; category as in CATEGORIES; planted: the effects besides noise."""

    category: str
    seed: int
    stage: Stage
    u_V: Floats
    Ts_s: float
    aux: Mapping[str, Floats]
    excitation: str

    @property
    def planted(self) -> tuple[str, ...]:
        """Names of what is hidden, in the vocabulary of causes: what stands outside it is `unknown`."""
        active = [name for name in self.stage.active if name != "memory" or not isinstance(self.stage.memory, Curve)]
        return tuple("unknown" if name == "stick_slip" else name for name in active)


def scenario(category: str, seed: int) -> Scenario:
    """The scenario of a category and a seed; the same arguments give the same scenario."""
    rng = np.random.default_rng([seed, CATEGORIES.index(category)])
    Ts_s = 1.0 / float(rng.choice(RATES_HZ))
    samples = int(rng.uniform(6000, 9000))
    low_V, high_V = float(rng.uniform(-18.0, 10.0)), float(rng.uniform(70.0, 118.0))
    kind = "good" if category != "poor" else str(rng.choice(POOR))
    u_V = good(rng, samples, low_V, high_V) if kind == "good" else poor(kind, rng, samples, low_V, high_V)
    stroke_um = float(np.exp(rng.uniform(np.log(2.0), np.log(80.0))))
    span_um = stroke_um * (high_V - low_V) / 120.0
    # A converter resolves 16 bits of its range, whatever the stage; noise is 2e-5 to 5e-4 of the stroke.
    stage = Stage(
        stroke_um=stroke_um,
        lag_s=Ts_s * float(np.exp(rng.uniform(np.log(2.0), np.log(40.0)))),
        sensor_step_um=0.0,
        adc_low_um=-0.8 * stroke_um,
        adc_high_um=2.0 * stroke_um,
        memory=_hysteresis(rng, category, stroke_um),
        noise=Noise(stroke_um * float(np.exp(rng.uniform(np.log(2e-5), np.log(5e-4))))),
    )
    names: tuple[str, ...] = ()
    if category in EFFECTS:
        names = (category,)
    elif category == "pair":
        names = tuple(str(name) for name in rng.choice(EFFECTS, 2, replace=False))
    elif category == "poor":
        names = (str(rng.choice(EFFECTS)),)
    elif category == "unknown":
        stage = stage.with_effects(stick_slip=float(rng.uniform(0.02, 0.06)) * span_um)
    aux = {"axis2_V": wandering(rng, samples, 0.0, 100.0)} if rng.random() < 0.3 or "coupling" in names else {}
    for name in names:
        stage = stage.with_effects(**{name: _strength(name, rng, u_V, Ts_s, stage, span_um)})
    return Scenario(category, seed, stage, u_V, Ts_s, aux, kind)


def memory_only(hidden: Scenario) -> Scenario:
    """The same stage, driven the same way, with nothing but its hysteresis."""
    bare = dict.fromkeys((*(name for name in hidden.stage.active if name != "memory"),))
    return dataclasses.replace(hidden, category="memory", stage=hidden.stage.with_effects(**bare))


def _hysteresis(rng: np.random.Generator, category: str, stroke_um: float) -> Preisach | Relays | BoucWen | Curve:
    choice = rng.random()
    if category == "none":
        bend = float(rng.uniform(0.0, 0.15)) * stroke_um
        v = np.linspace(-0.5, 1.5, 201)
        return Curve(-60.0, 1.2, tuple((stroke_um * v + bend * v * (1.0 - v)).tolist()))
    density = Density(float(rng.uniform(25, 60)), float(rng.uniform(45, 75)), float(rng.uniform(5, 35)), 65.0)
    share = float(rng.uniform(0.25, 0.5))
    if choice < 0.55:
        return Preisach(density, share)
    if choice < 0.75:
        return Relays(density, share, count=400)
    return BoucWen(float(rng.uniform(0.04, 0.09)) * stroke_um, float(rng.uniform(10, 23)), float(rng.uniform(0.5, 0.8)))


def _strength(name: str, rng: np.random.Generator, u_V: Floats, Ts_s: float, stage: Stage, span_um: float) -> object:
    """Arguments of the effect `name`, drawn so that its own share of the error spans a decade or two."""
    span_s = Ts_s * len(u_V)
    low_V, high_V = float(u_V.min()), float(u_V.max())
    share = float(np.exp(rng.uniform(np.log(0.002), np.log(0.05))))
    if name == "creep":
        return (share * 0.8, span_s / 400.0, 1000.0 * span_s)
    if name == "resonance":
        f_Hz = float(np.exp(rng.uniform(np.log(0.01), np.log(0.12)))) / Ts_s
        return (f_Hz, float(rng.uniform(0.01, 0.06)), float(rng.uniform(0.1, 0.7)))
    if name == "delay":
        return float(rng.uniform(0.5, 12.0))
    if name == "saturation":
        cut = float(rng.uniform(0.04, 0.25)) * (high_V - low_V)
        side = rng.integers(3)
        return (low_V + cut if side != 0 else -60.0, high_V - cut if side != 1 else 160.0)
    if name == "slew":
        rates = np.abs(np.diff(u_V)) / Ts_s
        return float(np.quantile(rates[rates > 0], rng.uniform(0.75, 0.97)))
    if name == "drift":
        return (float(rng.choice([-1, 1])) * 2.0 * share * span_um / span_s,)
    if name == "periodic":
        f_Hz = float(np.exp(rng.uniform(np.log(40.0 / span_s), np.log(0.2 / Ts_s))))
        return (f_Hz, share * span_um, float(rng.uniform(0.0, 6.0)))
    if name == "aging":
        return (float(rng.choice([-1, 1])) * 2.0 * share, span_s)
    if name == "outliers":
        return (float(rng.uniform(1e-3, 5e-3)), 8.0 * share * span_um)
    return {"axis2_V": float(rng.choice([-1, 1])) * share * span_um / 30.0}
