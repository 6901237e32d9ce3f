"""Causes on stages that share no equation with the model, the probe, or the virtual stage."""

from __future__ import annotations

import pytest

from fixtures.foreign_stages import EFFECTS, FAMILIES, foreign_record
from hysgen.diagnosis.procedure import name_causes

MOST_WRONG = 3
"""Of twenty records: with 95 % of them right, more are wrong once in sixty times."""


@pytest.mark.proof
def test_hidden_effects_are_named_on_foreign_stages() -> None:
    wrong = {}
    for family in FAMILIES:
        for seed, effect in enumerate(EFFECTS):
            names = name_causes(foreign_record(family, effect, seed)).names
            if set(names) != {"memory", *filter(None, [effect])}:
                wrong[family, effect] = names
    assert len(wrong) <= MOST_WRONG, wrong
