"""Models drawn at random, of other structures and numbers than any that was fitted: what `verify` also compares."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from hysgen.model.model import Grid, Model
from hysgen.model.path import block_from_json
from hysgen.model.terms import term_from_json

RULES: Final = (6, 13, 3, 12, 50, 2, 9, 25, 4, 11, 17, 7, 33, 5, 8, 10)
"""Every dense size, the first windowed one, and larger ones; mixed, so that the first few differ much."""


def random_model(seed: int) -> Model:
    """A stable model with a gain of one sign: random rules, range, sampling rate, terms and input blocks.

    Seeds 0 .. len(RULES) - 1 cover every number of rules in RULES.
    """
    rng = np.random.default_rng(seed)
    rules = RULES[seed % len(RULES)]
    low = rng.uniform(-5.0, 5.0)
    span = rng.uniform(0.5, 20.0)
    sign = rng.choice([-1.0, 1.0])
    consequents = np.column_stack(
        [
            rng.uniform(-0.3, 0.9, rules),
            sign * rng.uniform(0.5e-3, 4e-3, rules),
            rng.uniform(low, low + span, rules) * rng.uniform(0.0, 0.5, rules),
        ]
    )
    terms = [term_from_json(data) for data in _terms(rng)]
    weights = np.concatenate([np.zeros(0), *(rng.normal(0.0, 1e-4, term.size) for term in terms)])
    return Model(
        name=f"random_{seed}",
        Ts_s=float(rng.choice([1e-5, 2e-5, 1e-4])),
        grid=Grid(low, low + span, rules),
        consequents=consequents,
        u_min_V=float(rng.choice([-20.0, 0.0, -120.0])),
        u_max_V=float(rng.choice([100.0, 120.0, 1000.0])),
        terms=tuple(terms),
        weights=weights,
        blocks=tuple(block_from_json(data) for data in _blocks(rng)),
    )


def kin(model: Model, seed: int) -> Model:
    """The same structure with other numbers: every parameter changed by up to 5 %."""
    rng = np.random.default_rng(seed)
    changed = model.with_parameters(model.parameters * rng.uniform(0.95, 1.05, model.parameters.size))
    return dataclasses.replace(changed, name=f"{model.name}_kin")


def faint_model() -> Model:
    """A model whose numbers lie just above the least magnitude that counts: its results often fall below it."""
    rng = np.random.default_rng(0)
    consequents = np.ldexp(rng.uniform(1.0, 2.0, (4, 3)), rng.integers(-38, -30, (4, 3)))
    return Model("faint", 2e-5, Grid(-1e-3, 1e-3, 4), consequents, u_min_V=-1.0, u_max_V=1.0)


def _terms(rng: np.random.Generator) -> list[Mapping[str, Any]]:
    count = int(rng.integers(1, 13))
    choices: list[Mapping[str, Any]] = [
        {"kind": "memory", "thresholds_V": list(np.cumsum(rng.uniform(0.5, 8.0, count))), **_bent(rng)},
        {"kind": "creep", "tau_s": sorted(rng.uniform(1e-3, 10.0, 3))},
        {"kind": "resonance", "f_Hz": [float(rng.uniform(100.0, 2000.0))], "zeta": [0.02]},
        {"kind": "periodic", "f_Hz": [50.0, 150.0]},
        {"kind": "drift", "tau_s": 0.5, "limit_um": 0.1},
        {"kind": "coupling", "channels": ["other"], "low": [0.0], "high": [40.0], "taps": int(rng.integers(1, 4))},
    ]
    return [choice for choice in choices if rng.random() < 0.4]


def _bent(rng: np.random.Generator) -> Mapping[str, Any]:
    """Polynomials of the plays, or none."""
    degree = int(rng.integers(1, 4))
    return {"degree": degree, "range_V": [-100.0, 120.0]} if degree > 1 else {}


def _blocks(rng: np.random.Generator) -> list[Mapping[str, Any]]:
    choices: list[Mapping[str, Any]] = [
        {"kind": "saturation", "low_V": -10.0, "high_V": 95.0},
        {"kind": "slew", "rise_V_s": 2e5, "fall_V_s": 1e5},
        {"kind": "delay", "samples": float(rng.uniform(0.0, 6.0))},
    ]
    return [choice for choice in choices if rng.random() < 0.25]
