"""Each cause's own evidence: it holds where the cause is, and not where something else only looks like it."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.linear_stage import (
    AGING,
    AXIS2_V,
    CLIPPED,
    COUPLED,
    CREEP,
    DRIFTING,
    HUMMING,
    KNOCKED,
    LAG,
    LATE,
    PLANTED,
    SLOW_AMPLIFIER,
    SPAN_S,
    T_S,
    evidence,
    lines_Hz,
    scene,
)
from hysgen.diagnosis.causes import Residual, causes
from hysgen.diagnosis.causes.aging import GainChange
from hysgen.diagnosis.causes.creep import PER_DECADE, CreepPart
from hysgen.diagnosis.causes.drift import DriftPart, Trend, trend_course
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.identifiability import abilities
from hysgen.diagnosis.probe import Chain, linear_fit, refine
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes

Floats = NDArray[np.float64]

BESIDE = {"drift": DRIFTING, "aging": AGING, "periodic": HUMMING, "coupling": COUPLED, "unknown": KNOCKED}
"""Chains that hold the causes of which `PLANTED` only has the displacement."""

PRESENT = {name: (BESIDE.get(name, stage), more_um) for name, (stage, more_um) in PLANTED.items()}


@pytest.mark.parametrize("name", PRESENT)
def test_evidence_of_a_planted_cause_is_many_standard_errors(name: str) -> None:
    chain, more_um = PRESENT[name]
    assert evidence(name, scene(chain, more_um, {"axis2_V": AXIS2_V}), chain).z > 5.0


def test_creep_of_a_move_before_the_record_does_not_change_the_estimate() -> None:
    """Creep of an unknown move by half the range, half a second before the first sample."""
    before_um = 0.02 * 5.0 * np.log10((SPAN_S + 0.5) / (T_S + 0.5))
    chain = CREEP.having(CreepPart(0.02, 0.05, 50.0, 0.05 * SPAN_S))
    result = evidence("creep", scene(CREEP, before_um), chain).parameters["per_decade"]
    assert result.value == pytest.approx(0.02, rel=0.02)


def test_a_line_with_a_changing_phase_is_not_periodic() -> None:
    turned = np.where(T_S < 0.2 * SPAN_S, -1.0, 1.0) * 0.01 * np.sin(2 * math.pi * 50.3 * T_S)
    fit = linear_fit(scene(LAG, turned), HUMMING)
    result = causes()["periodic"].signature(Residual(scene(LAG, turned), fit), fit)
    assert "phase not kept" in result.text


@pytest.mark.parametrize(("share", "unknown"), [(0.003, True), (0.05, False)])
def test_a_drift_whose_law_is_at_its_bound_is_said_to_go_on_as_nobody_knows(share: float, unknown: bool) -> None:
    """The log from the bound on and an exponential beside a ramp explain the rows equally; later they differ."""
    law = LAG.having(DriftPart(share * SPAN_S))
    text = evidence("drift", scene(LAG, 0.03 * trend_course(T_S, share * SPAN_S)), law).text
    assert ("the rows do not say how it goes on" in text) == unknown


@pytest.mark.parametrize(("periods", "proposed"), [(3.3, False), (4.7, True)])
def test_a_proposed_line_has_at_least_one_period_in_each_quarter(periods: float, proposed: bool) -> None:
    seen = scene(LAG, 0.01 * np.sin(2.0 * np.pi * periods * T_S / SPAN_S))
    chains = causes()["periodic"].proposals(Residual(seen, refine(seen, LAG)))
    assert any(abs(line_Hz * SPAN_S - periods) < 1.0 for chain in chains for line_Hz in lines_Hz(chain)) == proposed


@pytest.mark.parametrize("lag_s", [4e-3, 40e-3, 200e-3])
def test_creep_starts_within_a_twentieth_of_the_record_or_right_behind_the_lag(lag_s: float) -> None:
    """Behind three lags the stage still moves; what starts later than that shows in too few decades to be fitted."""
    seen = scene(Chain(lag_s))
    starts_s = [chain.of(CreepPart).from_s for chain in causes()["creep"].proposals(Residual(seen, refine(seen, LAG)))]
    fastest_s = 3.0 * refine(seen, LAG).chain.lag_s
    assert min(starts_s) == pytest.approx(fastest_s, rel=1e-9)
    assert max(starts_s) == pytest.approx(max(fastest_s, 0.05 * SPAN_S), rel=1e-9)


RINGS = LAG.having(Modes((40.0, 90.0), (0.03, 0.05), (-0.2, 0.3), 1.0))
HUMS = LAG.having(Periodic((50.0, 120.0)))
HUMS_UM = 0.010 * np.sin(100.0 * np.pi * T_S) + 0.004 * np.cos(240.0 * np.pi * T_S)
AGED_UM, COUPLED_UM = PLANTED["aging"][1], PLANTED["coupling"][1]
TRUE: list[tuple[str, Chain, Floats | float, dict[str, float], Extension]] = [
    ("delay", LATE, 0.0, {"delay_samples": 1.7}, Extension(block=Delay(1.7), lag_s=4e-3)),
    ("slew", SLOW_AMPLIFIER, 0.0, {"rate_V_per_s": 800.0}, Extension(block=Slew(800.0, 800.0), lag_s=4e-3)),
    ("saturation", CLIPPED, 0.0, {"high_V": 80.0}, Extension(block=Saturation(high_V=80.0), lag_s=4e-3)),
    ("resonance", RINGS, 0.0, {"f_Hz": 40.0, "zeta": 0.03, "share": -0.2, "f_2_Hz": 90.0, "zeta_2": 0.05,
     "share_2": 0.3}, Extension(block=Modes((40.0, 90.0), (0.03, 0.05), (-0.2, 0.3), 4e-3), lag_s=4e-3)),
    ("creep", CREEP, 0.0, {"per_decade": 0.02},
     Extension(block=CreepPart(0.02, 0.05).slow_states(4.0, PER_DECADE), lag_s=4e-3)),
    ("periodic", HUMS, HUMS_UM, {"f_Hz": 50.0, "amplitude_um": 0.01, "f_2_Hz": 120.0, "amplitude_2_um": 0.004},
     Extension(term=Periodic((50.0, 120.0)))),
    ("coupling", COUPLED, COUPLED_UM, {"axis2_V_um_per_unit": 0.001},
     Extension(term=Coupling(("axis2_V",), (AXIS2_V.min(),), (AXIS2_V.max(),)))),
    ("aging", AGING, AGED_UM, {"per_s": 0.003, "fraction": 0.003 * SPAN_S},
     Extension(correction=GainChange(0.003, 0.0, T_S[-1]), forgetting_s=0.35 * SPAN_S)),
    ("drift", DRIFTING, 0.05 * T_S / SPAN_S, {"ramp_um_per_s": 0.05 / SPAN_S},
     Extension(correction=Trend(0.0125, None, SPAN_S))),
    ("drift", LAG.having(DriftPart(0.2)), 0.03 * trend_course(T_S, 0.2), {"um_per_decade": 0.03, "since_s": 0.2},
     Extension(correction=Trend(0.03, 0.2, SPAN_S))),
]  # fmt: skip


@pytest.mark.parametrize(("name", "chain", "more_um", "values", "extension"), TRUE, ids=[case[0] for case in TRUE])
def test_a_fit_of_the_true_chain_says_and_extends_what_was_planted(
    name: str, chain: Chain, more_um: Floats | float, values: dict[str, float], extension: Extension
) -> None:
    """Values within five standard errors, z that of the least certain amount, numbers of the extension within 1 %."""
    seen = scene(LAG if name == "aging" else chain, more_um, {"axis2_V": AXIS2_V})
    residual = Residual(seen, linear_fit(seen, chain))
    found = causes()[name].signature(residual, linear_fit(seen, LAG))
    for key, value in values.items():
        estimate = found.parameters[key]
        assert abs(estimate.value - value) <= 5.0 * np.nan_to_num(estimate.standard_error) + 1e-12, key
    if name not in ("saturation", "periodic"):  # whose evidence is a slope, and the height above the background
        sizes = [abs(e.value) / e.standard_error for key, e in found.parameters.items() if key[:2] not in ("f_", "ze")]
        assert found.z == pytest.approx(np.nanmin(sizes))
    made = causes()[name].extension(residual)
    assert (type(made.block), type(made.term)) == (type(extension.block), type(extension.term))
    for part in ("block", "term", "correction", "lag_s", "forgetting_s"):
        wanted, got = getattr(extension, part), getattr(made, part)
        assert numbers(got) == pytest.approx(numbers(wanted), rel=0.01, abs=1e-4), part
    assert trend_course(np.array([0.0, 4.5, 49.5]), 0.5) == pytest.approx([0.0, 1.0, 2.0]), "by the decade"


def numbers(part: object) -> list[float]:
    """Every number in a part of an extension, in the order of its fields."""
    if isinstance(part, int | float):
        return [float(part)]
    inside = part if isinstance(part, tuple) else vars(part).values() if hasattr(part, "__dict__") else ()
    return [number for inner in inside for number in numbers(inner)]


@pytest.mark.parametrize(("lines", "verdict"), [(25, "above"), (1, "hidden")])
def test_a_fall_of_a_mode_shows_where_its_amplitude_changes(lines: int, verdict: str) -> None:
    """Of one line the amplitude is one: a mode that softens is a mode at a lower frequency."""
    chain, lines_Hz = LAG.having(Modes((83.0,), (0.02,), (0.3,), LAG.lag_s)), 83.0 + 2.0 * np.arange(lines)
    u_V = 50.0 + 8.0 * np.sin(2.0 * np.pi * np.multiply.outer(T_S, lines_Hz) + np.arange(lines) ** 2).sum(axis=1)
    rings = scene(chain, u_V=u_V)
    residual = Residual(rings, refine(rings, chain))
    (able,) = (ability for ability in abilities(residual, residual, {"resonance": None}) if ability.name == "softening")
    assert able.verdict == verdict
    assert (able.least or 0.0) < 1e-3
