"""Random models of other structures and numbers than the fitted one; `verify` compares them too."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Final, TypeVar

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.errors import CertificateError
from hysgen.float32.coefficients import coefficients, commit_numbers
from hysgen.model.disturbances import Term
from hysgen.model.disturbances import kinds as term_kinds
from hysgen.model.model import Grid, Model
from hysgen.model.path import InputBlock
from hysgen.model.path import kinds as block_kinds

T = TypeVar("T", Term, InputBlock)

SPAN_V: Final = 140.0
HALVINGS: Final = 10
RULES: Final = (6, 13, 3, 12, 50, 2, 9, 25, 4, 11, 17, 7, 33, 5, 8, 10)
"""Every dense size, the first windowed one, and larger ones; mixed, so that the first few differ much."""


def random_model(seed: int) -> Model:
    """A stable model with a gain of one sign: random rules, range, sampling rate, terms and input blocks.

    Seeds 0 .. len(RULES) - 1 cover every number of rules in RULES.
    """
    rng = np.random.default_rng(seed)
    terms, blocks = _some(term_kinds().values(), rng, 0.4), _some(block_kinds().values(), rng, 0.25)
    return _model(f"random_{seed}", RULES[seed % len(RULES)], terms, blocks, rng)


def complete_model(seed: int) -> Model:
    """A random model with every kind of term and input block, each in the form that a diagnosis delivers."""
    rng = np.random.default_rng(seed)
    terms = [kind.examples(rng)[0] for kind in term_kinds().values()]
    blocks = [kind.examples(rng)[0] for kind in block_kinds().values()]
    return _model(f"complete_{seed}", RULES[seed % len(RULES)], terms, blocks, rng)


def _model(name: str, rules: int, terms: list[Term], blocks: list[InputBlock], rng: np.random.Generator) -> Model:
    """The model; behind responses of the stage, its gains are those of the same span of w instead of SPAN_V.

    A term whose kind is that of a block too is left out: in C their functions would have the same names.
    """
    terms = [term for term in terms if term.kind not in block_kinds()]
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
    model = Model(
        name=name,
        Ts_s=float(rng.choice([1e-5, 2e-5, 1e-4])),
        grid=Grid(low, low + span, rules),
        consequents=consequents,
        u_min_V=float(rng.choice([-20.0, 0.0, -120.0])),
        u_max_V=float(rng.choice([100.0, 120.0, 1000.0])),
        terms=tuple(terms),
        weights=np.concatenate([np.zeros(0), *(rng.normal(0.0, 1e-4, term.size) for term in terms)]),
        blocks=tuple(sorted(blocks, key=lambda block: block.place)),
    )
    if model.responds:
        model.consequents[:, 1] *= SPAN_V / model.w_range.width
    return model


def perturbed_model(model: Model, seed: int) -> Model:
    """The same structure with other numbers: every parameter changed by up to 5 %.

    With a learner, by half of that, a quarter and so on, until the certificates hold that `commit` starts from.
    """
    directions = np.random.default_rng(seed).uniform(-1.0, 1.0, model.parameters.size)
    for halvings in range(HALVINGS):
        changed = model.with_parameters(model.parameters * (1.0 + 0.05 * 0.5**halvings * directions))
        changed = dataclasses.replace(changed, name=f"{model.name}_perturbed")
        if model.learner is None or _can_commit(changed):
            break
    return changed


def _can_commit(model: Model) -> bool:
    try:
        commit_numbers(model, coefficients(model), certify(model))
    except CertificateError:
        return False
    return True


def low_gain_model() -> Model:
    """A model whose numbers lie just above the least magnitude that counts: its results often fall below it."""
    rng = np.random.default_rng(0)
    consequents = np.ldexp(rng.uniform(1.0, 2.0, (4, 3)), rng.integers(-38, -30, (4, 3)))
    return Model("low_gain", 2e-5, Grid(-1e-3, 1e-3, 4), consequents, u_min_V=-1.0, u_max_V=1.0)


def _some(kinds: Iterable[type[T]], rng: np.random.Generator, share: float) -> list[T]:
    """An example of a random form of each kind, left out at random so that the given share of the kinds stays."""
    examples = [forms[rng.integers(len(forms))] for forms in (kind.examples(rng) for kind in kinds)]
    return [example for example in examples if rng.random() < share]
