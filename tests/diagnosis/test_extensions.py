"""What is made of a named cause: certificates are kept, plays chosen by rows left out, and the price is result."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fixtures.bank_records import known
from hysgen.certify.certificates import certify
from hysgen.diagnosis.causes.drift import Trend
from hysgen.diagnosis.causes.memory import usual_memory
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.extension_forms import with_best_forms
from hysgen.diagnosis.ladder import add_online_parts, fit_ladder
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.probe import rms
from hysgen.fitting import FitSettings
from hysgen.model.model import Model
from hysgen.model.terms.creep import Creep
from hysgen.model.terms.memory import Memory
from hysgen.model.terms.play_slopes import slopes
from hysgen.record import Record
from hysgen.report.words import price_of
from hysgen.studies.bank.scenario import scenario

USUAL = FitSettings()


def held_um(prepared: Prepared, extensions: dict[str, Extension], names: list[str]) -> float:
    return rms(fit_ladder(prepared, extensions, names, USUAL).error_um[prepared.held_rows])


def test_the_fit_limits_a_mode_so_that_the_inverse_keeps_its_certificate() -> None:
    prepared, extensions = known("resonance", 1)
    free = fit_ladder(prepared, extensions, list(extensions), dataclasses.replace(USUAL, certified=False))
    assert not certify(free.model).inverse_holds
    kept = fit_ladder(prepared, extensions, list(extensions), USUAL)
    assert certify(kept.model).inverse_holds
    assert certify(kept.model).contraction_holds


def test_creep_lowers_the_held_out_error_and_keeps_the_certificate_of_the_inverse() -> None:
    prepared, extensions = known("creep", 1)
    with_um, without_um = (held_um(prepared, extensions, names) for names in (["memory", "creep"], ["memory"]))
    assert with_um < without_um
    creep = fit_ladder(prepared, extensions, ["memory", "creep"], USUAL).model
    assert certify(creep).inverse_holds
    assert isinstance(creep.terms[1], Creep)
    assert creep.weights[-1] * creep.consequents[:, 1].mean() > 0.0  # onward, in the direction of the gain


def test_plays_with_powers_have_a_positive_slope_also_outside_the_fitted_range() -> None:
    # The held-out part of this record leaves the range of the rest: free squares and cubes fall 3.5 times only there.
    prepared, extensions = known("memory", 4)
    rung = fit_ladder(prepared, extensions, ["memory"], USUAL)
    term, gain = rung.model.terms[0], rung.model.consequents[:, 1].mean()
    assert isinstance(term, Memory)
    x = term.reach * np.linspace(-1.0, 1.0, 201)[:, None]
    each = slopes(x, np.ones(x.shape, dtype=bool), term.middle_and_half_V[1]) * rung.model.weights.reshape(3, 1, -1)
    rise = each.sum(axis=0)[:, 1:] / gain
    assert rise.min() > -0.02 * rise.max()
    assert held_um(prepared, {}, []) > 7.0 * rms(rung.error_um[prepared.held_rows])


@pytest.mark.slow
def test_the_form_of_the_plays_is_chosen_by_cross_validation_and_the_usual_form_kept_in_doubt() -> None:
    prepared, known_ones = known("memory", 5)
    assert with_best_forms(prepared, known_ones, ["memory"], USUAL)["memory"].term == known_ones["memory"].term
    u_V = scenario("memory", 5).u_V[:3500]
    low_V, high_V = float(u_V.min()), float(u_V.max())
    usual = {"memory": Extension(term=usual_memory(low_V, high_V))}
    assert usual["memory"].term is not None

    def chosen(weights: np.ndarray, noise_um: float) -> Memory:
        plays = Memory.polynomial(weights.size, 1, low_V, high_V)
        z = np.zeros(u_V.size)
        y_um = np.zeros(u_V.size)
        state = np.full(weights.size, u_V[0])
        r = np.asarray(plays.thresholds_V)
        for k in range(u_V.size - 1):
            z[k] = weights @ state
            y_um[k + 1] = y_um[k] + 0.2 * (0.05 * u_V[k] + z[k] - y_um[k])
            state = np.clip(state, u_V[k] - r, u_V[k] + r)
        y_um += noise_um * np.random.default_rng(2).normal(size=u_V.size)
        term = with_best_forms(prepare(Record.from_arrays(u_V, y_um, 1e-3)), usual, ["memory"], USUAL)["memory"].term
        assert isinstance(term, Memory)
        return term

    assert chosen(0.003 * np.ones(12), 1e-3).degree == 1
    assert chosen(0.003 * np.ones(12), 0.2).size < usual["memory"].term.size  # noise that 33 weights would follow


def runs(names: list[str]) -> Model:
    """A model as a diagnosis delivers it, with memory of 2 plays: what is priced does not depend on their number."""
    prepared, _ = known("memory", 8)
    term = Memory.polynomial(2, 1, *prepared.record.u_range_V)
    every = {"memory": Extension(term=term), "aging": Extension(forgetting_s=3.0), "outliers": Extension(gate=True)}
    every["drift"] = Extension(correction=Trend(1e-9))
    model = fit_ladder(prepared, every, names, USUAL).model
    return add_online_parts(model, [every[name] for name in names], 1.0, 1e-4)


@pytest.mark.parametrize("cause", ["drift", "aging"])
@pytest.mark.slow
def test_the_price_includes_the_terms_and_the_learner_for_operation(cause: str) -> None:
    before, after = price_of(runs(["memory"])), price_of(runs(["memory", cause]))
    assert before is not None
    assert after is not None
    assert after.cycles > before.cycles
    assert after.bytes > before.bytes
