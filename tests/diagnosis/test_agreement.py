"""The search on a linear stage: where it goes on, where it stops, and which cause it takes for another."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGED_UM,
    CREEP,
    LAG,
    LATE,
    SAMPLES,
    SPAN_S,
    T_S,
    scene,
)
from hysgen.diagnosis import search, swaps
from hysgen.diagnosis.advice import unexplained_structure
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.causes.resonance import ResonancePart
from hysgen.diagnosis.causes.saturation import SaturationPart
from hysgen.diagnosis.causes.slew import SlewPart
from hysgen.diagnosis.probe import Chain, Mode, refine
from hysgen.diagnosis.search import SearchResult
from hysgen.record.noise import NoiseFloor

CHECKED = np.arange(60, SAMPLES, 3)


@pytest.mark.parametrize(
    ("left_um", "noise_um", "said"), [(0.030, 0.001, True), (0.020, 0.001, False), (0.030, 0.015, False)]
)
def test_unexplained_structure_requires_a_quarter_per_cent_of_the_span_and_more_than_the_noise(
    left_um: float, noise_um: float, said: bool
) -> None:
    wave = np.sin(np.arange(SAMPLES) / 40.0)
    prepared: Any = SimpleNamespace(y_um=5.0 * wave, u_V=50.0 * wave, cut=SAMPLES)  # 10 um of span
    seen = SimpleNamespace(
        scene=SimpleNamespace(rows=np.arange(SAMPLES)), fit=SimpleNamespace(error=math.sqrt(2.0) * left_um * wave)
    )
    result = unexplained_structure(prepared, cast(SearchResult, seen), NoiseFloor(noise_um, "plateaus", SAMPLES))
    assert (result is not None) == said


def test_search_stops_when_the_residual_is_noise() -> None:
    seen = scene(LAG)
    assert search.forward_step(seen, refine(seen, LAG), CHECKED) is None


def test_search_adds_a_cause_whose_effect_is_below_the_noise() -> None:
    seen = scene(LAG, 2e-3 * T_S / SPAN_S)
    step = search.forward_step(seen, refine(seen, LAG), CHECKED)
    assert step is not None
    assert search.present(step.chain) == ["drift"]


LIMITED, CLIPPED_AT_60 = LAG.having(SlewPart(800.0)), LAG.having(SaturationPart(high_V=60.0))


@pytest.mark.parametrize(
    ("stage", "more_um", "wrong", "right"),
    [
        (LATE, 0.0, LAG.having(ResonancePart((Mode(120.0, 0.3, 0.5),))), "delay"),
        (LAG, AGED_UM, LAG.having(DriftPart()), "aging"),
        (CREEP, 0.0, LAG.having(DriftPart(1.0)), "creep"),
        (CLIPPED_AT_60, 0.0, LIMITED, "saturation"),
        (LIMITED, 0.0, CLIPPED_AT_60, "slew"),
    ],
)
def test_a_cause_is_swapped_for_a_similar_cause_with_a_smaller_error(
    stage: Chain, more_um: float | NDArray[np.float64], wrong: Chain, right: str
) -> None:
    seen = scene(stage, more_um)
    assert search.present(swaps.swap_similar_causes(seen, refine(seen, wrong), CHECKED).chain) == [right]


def test_a_slow_cause_without_evidence_is_swapped_for_one_with_evidence() -> None:
    seen = scene(LAG, AGED_UM)
    right = swaps.swap_slow_causes(seen, refine(seen, CREEP), CHECKED).chain
    assert search.present(right) == ["aging"]


def test_a_slow_cause_without_evidence_is_removed_if_it_hides_the_evidence_of_another() -> None:
    seen = scene(LAG, 2e-3 * T_S / SPAN_S)
    both = refine(seen, LAG.having(CreepPart(1e-4, 0.05)).having(DriftPart()))
    drift = causes()["drift"]
    assert not drift.signature(Residual(seen, both), both).holds
    alone = swaps.swap_slow_causes(seen, both, CHECKED)
    assert search.present(alone.chain) == ["drift"]
    assert drift.signature(Residual(seen, alone), both).holds
