"""Numbers, limits and words of causes, score and answer on made-up inputs, each against a value made by hand."""

import dataclasses
import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hysgen.diagnosis import identifiability
from hysgen.diagnosis.answer import NamedCause, Price
from hysgen.diagnosis.causes import Estimate
from hysgen.diagnosis.causes.creep import PER_DECADE, CreepPart
from hysgen.diagnosis.causes.drift import Trend
from hysgen.diagnosis.evaluation import Study, confidence_text, share_text
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import (
    Gain,
    add_online_parts,
    blockwise_confidence,
    combined_confidence,
    gain,
    joint_shares,
)
from hysgen.fitting.operator import PathSize
from hysgen.model.file import load_model
from hysgen.model.path.delay import Delay
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes
from hysgen_lab.studies.bank.scenario import true_extension

WHITE = np.random.default_rng(11).normal(size=20_000)


# Causes


def test_true_parameters_of_a_plant_make_its_extensions() -> None:
    parameters = {"delay.delay_samples": 2.5, "slew.rate_V_per_s": 700.0, "periodic.f_Hz": 50.0}
    parameters |= {"saturation.low_V": 5.0, "saturation.high_V": 90.0, "creep.per_decade": 0.01, "creep.from_s": 0.1}
    parameters |= {"resonance.f_Hz": 80.0, "resonance.zeta": 0.04, "resonance.share": 0.5}
    known = parameters, {"x": (-2.0, 4.0)}, 10.0, 3e-3
    blocks = {"delay": Delay(2.5), "slew": Slew(700.0, 700.0), "saturation": Saturation(5.0, 90.0)}
    blocks |= {
        "creep": CreepPart(0.01, 0.1).slow_states(10.0, PER_DECADE),
        "resonance": Modes((80.0,), (0.04,), (0.5,), 3e-3),
    }
    for name, block in blocks.items():
        extension = true_extension(name, *known)
        assert extension is not None
        assert (extension.block, extension.lag_s, extension.on_path) == (block, 3e-3, True)
    term = true_extension("coupling", *known)
    assert term is not None
    assert (term.term.low, term.term.high) == ((-2.0,), (4.0,))  # type: ignore[union-attr]
    assert (memory := true_extension("memory", *known)) is not None
    assert (memory.size, memory.lag_s) == (PathSize(), 3e-3)
    assert true_extension("drift", *known) is None


# Score


# Bootstrap


def test_a_gain_of_constant_errors_is_exact_and_its_confidence_depends_on_the_share() -> None:
    before, after = np.full(480, 2.0), np.full(480, -1.5)
    found = gain(before, after)
    assert dataclasses.astuple(found) == (2.0, 1.5, 0.5, 0.5, 1.0)
    assert found.fall_um == 0.5
    for share, sure in ((0.24, 1.0), (0.26, 0.0)):
        assert gain(before, after, share).confidence == sure
        assert blockwise_confidence(before, after, share) == sure
        assert combined_confidence(before, after, share) == sure
    assert gain(after, before).confidence == 0.0


# Ladder and extension


def test_the_model_for_operation_has_the_bias_of_a_drift_and_forgets_as_fast_as_the_fastest() -> None:
    model = load_model("appendix_a")
    plain = add_online_parts(model, [Extension()], 1.0, 0.002)
    assert (plain.learner, plain.terms) == (model.learner, ())
    parts = [Extension(correction=Trend(0.1)), Extension(forgetting_s=2.0), Extension(forgetting_s=0.5)]
    made = add_online_parts(model, parts, 1.0, 0.002)
    assert made.weights.tolist() == [1.0]
    assert made.learner is not None
    assert (made.learner.noise_um, made.learner.forgetting) == (0.002, pytest.approx(1.0 - model.Ts_s / 0.5))
    assert made.learner.sliding == made.learner.forgetting
    for forgetting_s, kept in ((model.Ts_s, 0.9), (1e9, 1.0 - 1e-7)):
        bounded = add_online_parts(model, [Extension(forgetting_s=forgetting_s)], 1.0, 0.0)
        assert bounded.learner is not None
        assert (bounded.learner.forgetting, bounded.learner.noise_um) == (kept, 1e-9)
    gated = add_online_parts(model, [Extension(gate=True)], 1.0, 0.002).learner
    assert gated is not None


# Answer


STEP = Gain(0.030, 0.020, 0.008, 0.012, 0.97)


def cause(**more: Any) -> NamedCause:
    usual: dict[str, Any] = {
        "name": "creep",
        "parameters": {"per_decade": Estimate(0.02, 0.001)},
        "evidence": "it creeps",
        "statistic": 20.0,
        "step": STEP,
        "alone": Gain(0.03, 0.02, 0.009, 0.011, 1.0),
        "confidence": 0.9876,
        "bayes": 30.0,
        "probe_gain": 1.5,
        "share": 0.25,
        "cold_um": (0.035, 0.025),
        "price": Price(12, -8),
    }
    return NamedCause(**(usual | more))


def test_why_a_cause_is_not_extended_is_said() -> None:
    assert cause().why_not_extended == ""
    assert "gains less than 2 % on rows left out of the fit" in cause(extended=False).why_not_extended


def test_the_fall_of_rungs_that_raise_the_error_is_split_between_them_and_the_next() -> None:
    # Slew alone makes the model wrong, and with memory it removes most: its part is a half of what both remove.
    assert joint_shares([1.0, 359.0, 0.2], 0.0, [3.0, 3.0]) == (pytest.approx([0.4, 0.4]), pytest.approx(0.2))
    assert joint_shares([1.0, 0.4, 0.1], 0.0, [0.0, 0.0]) == (pytest.approx([0.6, 0.3]), pytest.approx(0.1))
    assert joint_shares([1.0, 0.1, 0.3], 0.0, [3.0, 1.0]) == (pytest.approx([0.525, 0.175]), pytest.approx(0.3))
    assert joint_shares([1.0, 1.5], 0.0, [2.0]) == ([0.0], 1.0)
    assert joint_shares([1.0], 0.0, []) == ([], 1.0)


def test_what_is_below_the_noise_is_nobodys_share() -> None:
    assert joint_shares([1.0, 0.4, 0.1], 0.2, [1.0, 1.0]) == (pytest.approx([0.75, 0.25]), 0.0)
    assert joint_shares([0.2, 0.1], 0.2, [1.0]) == ([0.0], 0.0)


@pytest.mark.parametrize("seed", range(20))
def test_shares_and_what_is_left_add_up_to_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    powers = [1.0, *np.exp(rng.normal(scale=2.0, size=rng.integers(1, 6))).tolist()]
    shares, left = joint_shares(powers, 0.5 * rng.random(), rng.normal(size=len(powers) - 1).tolist())
    assert min(*shares, left) >= 0.0
    assert sum(shares) + left == pytest.approx(1.0, abs=1e-12)


def test_a_cause_in_json_holds_every_number_in_its_place() -> None:
    found = json.loads(json.dumps(cause().to_json()))
    assert found["gain"] == {
        "free_run_rms_before": 0.03,
        "free_run_rms_after": 0.02,
        "ci95": [0.008, 0.012],
        "cold_before": 0.035,
        "cold_after": 0.025,
        "alone": {"fall_um": pytest.approx(0.01), "ci95": [0.009, 0.011]},
    }
    assert (found["log_bayes_factor"], found["separated_by_likelihood"]) == (15.0, True)
    assert (found["cost"], found["share"], found["extended"]) == ({"cycles": 12, "bytes": -8}, 0.25, True)
    assert (found["parameters"], found["standard_errors"]) == ({"per_decade": 0.02}, {"per_decade": 0.001})
    bare = cause(bayes=None, alone=None, price=None).to_json()
    assert (bare["log_bayes_factor"], bare["separated_by_likelihood"], bare["cost"]) == (None, False, None)
    assert bare["gain"]["alone"] is None


def test_the_ladder_shows_the_causes_in_the_model_between_the_paper_and_the_noise() -> None:
    diagnosis: Any = SimpleNamespace(
        causes=(cause(), cause(name="delay", extended=False), cause(name="outliers", confidence=None, price=None)),
        base_rms_um=0.03,
        base_own_um=0.029,
        noise=SimpleNamespace(rms_um=0.001),
    )
    study = Study(diagnosis, *[None] * 4, span_um=10.0)  # type: ignore[arg-type]
    assert study.improved
    assert study.percent(0.02) == 0.2
    assert study.ladder() == [
        ["paper's model", "0.03", "0.3 %", "0.029", *[""] * 5],
        ["+ creep", "0.025", "0.25 %", "0.02", "0.008 .. 0.012", "25.0 %", "+12", "-8", "0.988"],
        ["+ outliers", "0.025", "0.25 %", "0.02", "0.008 .. 0.012", "25.0 %", "", "", ""],
        ["noise floor", "0.001", "0.01 %", *[""] * 6],
    ]
    assert [share_text(cause(share=share)) for share in (0.0, 0.0004, 0.0005, 0.5)] == [
        "0.0 %",
        "< 0.1 %",
        "0.1 %",
        "50.0 %",
    ]
    assert (confidence_text(cause(confidence=None)), confidence_text(cause(confidence=1.0))) == ("", "1.000")


# Advice


def test_noise_that_its_past_does_not_predict_is_the_white_part() -> None:
    chirp = 5.0 * np.sin(2e-6 * np.arange(WHITE.size) ** 2.0)
    assert identifiability.unpredictable_um(0.01 * WHITE) == pytest.approx(0.01, rel=0.05)
    assert identifiability.unpredictable_um(0.01 * WHITE + chirp) == pytest.approx(0.01, rel=0.35)
    assert identifiability.unpredictable_um(WHITE[:255]) == math.inf
    assert identifiability.unpredictable_um(WHITE[:256]) < math.inf
    assert identifiability.unpredictable_um(0.01 * WHITE + 3.0 * np.arange(WHITE.size)) == pytest.approx(0.01, rel=0.05)


def said(error: Callable[[np.ndarray], np.ndarray]) -> str:
    k = np.arange(4000)
    u_V = 50.0 * (1.0 - np.cos(k / 50.0))
    prepared: Any = SimpleNamespace(u_V=u_V, y_um=0.1 * u_V)
    return identifiability.residual_in_words(error(k), prepared, k)


def test_a_residual_is_said_in_words() -> None:
    noise = 0.1 * WHITE[:4000]
    assert said(lambda k: noise) == "fast"
    assert said(lambda k: np.sin(k / 500.0)) == "slow"
    assert said(lambda k: noise * (1.5 - np.cos(k / 50.0))) == "fast, larger at high displacement"
    assert said(lambda k: noise * (1.5 + np.cos(k / 50.0))) == "fast, larger at low displacement"
    assert said(lambda k: np.sign(np.sin(k / 50.0)) * 0.1 + 0.5 * noise).endswith("depends on the direction")
    for jumps, words in ((5, "fast"), (6, "6 jumps, fast")):
        assert said(
            lambda k, n=jumps: 0.01 * noise + 0.3 * (np.searchsorted(np.arange(1, n + 1) * 300, k, "right") % 2)
        ) in (words, words.replace("fast", "slow"))
