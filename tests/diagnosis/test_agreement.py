"""Steps of the search and the agreement of evidence, need and gain, each alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGED_UM,
    COMMAND_V,
    CREEP,
    LAG,
    LATE,
    RINGING,
    SAMPLES,
    SPAN_S,
    T_S,
    scene,
)
from hysgen.diagnosis import procedure, search, swaps
from hysgen.diagnosis.advice import unexplained_structure
from hysgen.diagnosis.bootstrap import Gain
from hysgen.diagnosis.causes import Residual, Signature, causes
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.causes.delay import DelayPart
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.causes.resonance import ResonancePart
from hysgen.diagnosis.causes.saturation import SaturationPart
from hysgen.diagnosis.causes.slew import SlewPart
from hysgen.diagnosis.probe import Chain, Mode, linear_fit, refine
from hysgen.diagnosis.search import Found
from hysgen.record.noise import NoiseFloor

CHECKED = np.arange(60, SAMPLES, 3)


def found(chain: Any = LAG, **needs: float) -> Any:
    return SimpleNamespace(
        needs=needs, separated_by_likelihood=(), fit=SimpleNamespace(chain=chain), corrupted=np.zeros(0, dtype=bool)
    )


def agreed(
    monkeypatch: pytest.MonkeyPatch, creep: Signature, needs: float, sures: Iterator[float]
) -> tuple[list[str], dict[str, str]]:
    """What is named of memory, which is beyond doubt, and creep; and why the rest is not.

    sures: how sure the gain of creep is each time that gains are asked for.
    """

    def alone(prepared: Any, seen: Any, extensions: Any, names: list[str], settings: Any) -> dict[str, Gain]:
        sure = next(sures)
        return {name: Gain(2.0, 1.0, 0.5, 1.5, 1.0 if name == "memory" else sure) for name in names}

    monkeypatch.setattr(procedure, "_alone", alone)
    signatures = {"memory": Signature(True, 9.0, "loops"), "creep": creep}
    seen: Any = found(memory=20.0, creep=needs)
    named, _, refused = procedure._agreement(None, seen, signatures, {}, procedure.DiagnoseSettings())  # type: ignore[arg-type]
    return named, {one.name: one.why for one in refused}


@pytest.mark.parametrize(
    ("holds", "needs", "sure", "why"),
    [
        (True, 3.0, 0.9, None),
        (False, 3.0, 0.9, "the evidence is too weak: goes on"),
        (True, 1.1, 0.9, "the error grows only 1.10 times without it"),
        (True, 3.0, 0.6, "its extension does not lower the model's free-run error for certain"),
    ],
)
def test_a_cause_is_named_only_if_evidence_need_and_gain_agree(
    monkeypatch: pytest.MonkeyPatch, holds: bool, needs: float, sure: float, why: str | None
) -> None:
    named, refused = agreed(monkeypatch, Signature(holds, 6.0, "goes on"), needs, itertools.repeat(sure))
    assert named == (["memory"] if why else ["memory", "creep"])
    assert refused.get("creep") == why


@pytest.mark.parametrize(("later", "named"), [(0.8, ["memory"]), (0.96, ["memory", "creep"])])
def test_a_cause_that_is_asked_again_has_to_be_surer(
    monkeypatch: pytest.MonkeyPatch, later: float, named: list[str]
) -> None:
    """Each further time is one more chance to err."""
    sures = iter([0.6, 1.0, later, 1.0, later, 1.0])  # every second time memory is asked for alone
    told, _ = agreed(monkeypatch, Signature(True, 6.0, "goes on"), 3.0, sures)
    assert told == named


@pytest.mark.parametrize(("share", "pays"), [(0.05, True), (0.01, False)])
def test_an_extension_that_takes_one_per_cent_away_is_no_cause(
    monkeypatch: pytest.MonkeyPatch, share: float, pays: bool
) -> None:
    error: NDArray[np.float64] = np.random.default_rng(1).normal(size=2400)

    def checked_error(prepared: Any, extensions: Any, names: list[str], settings: Any) -> Any:
        return np.arange(error.size), error * (1.0 - share if "creep" in names else 1.0)

    monkeypatch.setattr(procedure, "checked_error", checked_error)
    gains = procedure._alone(None, found(), {}, ["creep"], None)  # type: ignore[arg-type]
    assert (gains["creep"].confidence > procedure.SURE) == pays


@pytest.mark.parametrize(
    ("left_um", "noise_um", "said"), [(0.012, 0.001, True), (0.009, 0.001, False), (0.012, 0.006, False)]
)
def test_what_is_left_is_unknown_only_above_a_thousandth_of_the_span_and_above_the_noise(
    left_um: float, noise_um: float, said: bool
) -> None:
    wave = np.sin(np.arange(SAMPLES) / 40.0)
    prepared: Any = SimpleNamespace(y_um=5.0 * wave, u_V=50.0 * wave, cut=SAMPLES)  # 10 um of span
    seen = SimpleNamespace(
        scene=SimpleNamespace(rows=np.arange(SAMPLES)), fit=SimpleNamespace(error=math.sqrt(2.0) * left_um * wave)
    )
    told = unexplained_structure(prepared, cast(Found, seen), NoiseFloor(noise_um, "plateaus", SAMPLES))
    assert (told is not None) == said


@pytest.mark.parametrize(("ramp_um", "taken"), [(0.009, False), (0.025, True)])
def test_a_step_that_takes_four_per_cent_away_is_not_taken(
    monkeypatch: pytest.MonkeyPatch, ramp_um: float, taken: bool
) -> None:
    """A ramp of 3 or 7 nm rms over 10 nm that nothing explains takes 4 or 21 per cent of it away."""
    ramp = causes()["drift"]
    monkeypatch.setattr(search, "causes", lambda: {"drift": ramp})
    seen = scene(LAG, 0.02 * np.sin(COMMAND_V / 5.0) + ramp_um * T_S / SPAN_S)
    fit = refine(seen, LAG)
    assert (search.forward_step(seen, fit, CHECKED) is not None) == taken


def test_search_stops_where_nothing_is_left() -> None:
    seen = scene(LAG)
    assert search.forward_step(seen, refine(seen, LAG), CHECKED) is None


def test_search_goes_on_to_an_effect_below_the_noise() -> None:
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
def test_a_cause_that_came_first_is_exchanged_for_the_one_like_it_that_explains_more(
    stage: Chain, more_um: float | NDArray[np.float64], wrong: Chain, right: str
) -> None:
    seen = scene(stage, more_um)
    assert search.present(swaps.swap_similar_causes(seen, refine(seen, wrong), CHECKED).chain) == [right]


def test_an_exchange_must_not_cost_more_on_the_fitted_rows_than_it_gains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(swaps, "ratio", lambda other, fit, checked: 0.9)
    seen = scene(RINGING)
    assert search.present(swaps.swap_similar_causes(seen, refine(seen, RINGING), CHECKED).chain) == ["resonance"]


def test_a_mode_that_does_not_ring_takes_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(swaps, "ratio", lambda other, fit, checked: 0.1 if other.chain.modes else 10.0)
    seen = scene(LATE)
    rough = linear_fit(seen, LATE.having(DelayPart(1.0)))
    mode = swaps.best_with(seen, linear_fit(seen, LAG), "resonance")
    assert mode is not None
    assert mode.rms_um < rough.rms_um
    assert search.present(swaps.swap_similar_causes(seen, rough, CHECKED).chain) == ["delay"]


def test_a_slow_cause_without_evidence_makes_room_for_another() -> None:
    seen = scene(LAG, AGED_UM)
    right = swaps.swap_slow_causes(seen, refine(seen, CREEP), CHECKED).chain
    assert search.present(right) == ["aging"]


def test_a_slow_cause_without_evidence_goes_where_it_hides_the_evidence_of_another() -> None:
    seen = scene(LAG, 2e-3 * T_S / SPAN_S)
    both = refine(seen, LAG.having(CreepPart(1e-4, 0.05)).having(DriftPart()))
    drift = causes()["drift"]
    assert not drift.signature(Residual(seen, both), both).holds
    alone = swaps.swap_slow_causes(seen, both, CHECKED)
    assert search.present(alone.chain) == ["drift"]
    assert drift.signature(Residual(seen, alone), both).holds
