"""Causes on stages that share no equation with the model, the probe, or the virtual stage."""

from __future__ import annotations

import pytest

from fixtures.foreign_stages import EFFECTS, FAMILIES, foreign_record, repeating_record
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


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("mode", [False, True])
def test_what_repeats_with_the_command_may_be_misfit_and_is_no_mode_until_it_rings(family: str, mode: bool) -> None:
    for seed in range(3):
        names = name_causes(repeating_record(family, seed, mode)).names
        assert set(names) == ({"memory", "resonance"} if mode else {"memory"})
