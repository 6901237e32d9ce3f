"""Models whose generated C the tests look at: the paper's, every term and block, many rules, a learner."""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.inputs.delay import Delay
from hysgen.inputs.saturation import Saturation
from hysgen.inputs.slew import Slew
from hysgen.learning import LearnerSettings
from hysgen.model import Grid, Model
from hysgen.model_file import load_model
from hysgen.terms.coupling import Coupling
from hysgen.terms.creep import Creep
from hysgen.terms.drift import Drift
from hysgen.terms.memory import Memory
from hysgen.terms.periodic import Periodic
from hysgen.terms.resonance import Resonance


def everything() -> Model:
    """Appendix A with every term and every input block, weights small enough for a certified inverse."""
    terms = (
        Memory.uniform(4, 60.0),
        Creep.spread(3, 1e-3, 10.0),
        Resonance((730.0,), (0.05,)),
        Periodic((50.0,)),
        Coupling(("temperature",), (20.0,), (24.0,), taps=2),
        Drift(0.1, 0.05),
    )
    weights = np.concatenate([1e-5 / np.array(term.scales(1.0)) * (-1.0) ** np.arange(term.size) for term in terms])
    return dataclasses.replace(
        load_model("appendix_a"),
        name="everything",
        terms=terms,
        weights=weights,
        blocks=(Saturation(-15.0, 110.0), Slew(2e6, 1.5e6), Delay(2.4)),
    )


def smooth(rules: int, terms: tuple[Memory, ...] = ()) -> Model:
    """A lag whose rules change smoothly over 0.5 .. 9 um."""
    l = np.linspace(0.0, 1.0, rules)  # noqa: E741
    consequents = np.column_stack([0.9 + 0.05 * l, 1.5e-3 + 5e-4 * l, 0.02 + 0.5 * l * (1.0 - l)])
    weights = np.full(sum(term.size for term in terms), 1e-5)
    return Model(f"smooth_{rules}", 2e-5, Grid(0.5, 9.0, rules), consequents, -20.0, 120.0, terms, weights)


def learning() -> Model:
    """Appendix A with a learner."""
    return dataclasses.replace(load_model("appendix_a"), name="learning", learner=LearnerSettings())


def extended() -> Model:
    """Appendix A with ten plays, two creep states, and a learner of the weights and the offsets."""
    terms = (Memory.uniform(10, 60.0), Creep.spread(2, 1e-2, 10.0))
    weights = np.concatenate([1e-5 / np.array(term.scales(1.0)) for term in terms])
    return dataclasses.replace(
        load_model("appendix_a"),
        name="extended",
        terms=terms,
        weights=weights,
        learner=LearnerSettings(learned=("offset", "terms")),
    )
