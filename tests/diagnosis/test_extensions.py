"""The model that is delivered for named causes: its error, the size of its hysteresis, its certificates, its price."""

import numpy as np
import pytest

from fixtures.bank_records import known
from hysgen.certify.certificates import certify
from hysgen.diagnosis.causes.drift import Trend
from hysgen.diagnosis.causes.hysteresis import SIZES
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import add_online_parts, fit_ladder, with_best_forms
from hysgen.diagnosis.prepare import Prepared, prepare
from hysgen.diagnosis.probe import rms
from hysgen.fitting import FitSettings, PathSize
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.record import Record
from hysgen.report.words import price_of
from hysgen_lab.studies.bank.scenario import scenario

USUAL = FitSettings()


def held_um(prepared: Prepared, extensions: dict[str, Extension], names: list[str]) -> float:
    return rms(fit_ladder(prepared, extensions, names, USUAL).error_um[prepared.held_rows])


@pytest.mark.parametrize(("category", "least"), [("memory", 20.0), ("creep", 20.0), ("resonance", 20.0)])
@pytest.mark.slow
def test_the_path_with_the_plants_own_parameters_lowers_the_held_out_error(category: str, least: float) -> None:
    """On three drawn stages each, over the error of the paper's model."""
    falls = []
    for seed in range(3):
        prepared, extensions = known(category, seed)
        falls.append(held_um(prepared, {}, []) / held_um(prepared, extensions, list(extensions)))
    assert np.median(falls) >= least
    assert min(falls) >= 0.25 * least


@pytest.mark.parametrize("category", ["memory", "creep", "resonance"])
def test_a_delivered_path_keeps_every_certificate(category: str) -> None:
    prepared, extensions = known(category, 1)
    found = certify(fit_ladder(prepared, extensions, list(extensions), USUAL).model)
    assert found.contraction_holds
    assert found.gain_holds
    assert found.inverse_holds
    assert found.w_unit == "um"


@pytest.mark.slow
def test_each_extension_of_the_path_lowers_the_held_out_error_beside_the_others() -> None:
    for category, cause in (("creep", "creep"), ("resonance", "resonance"), ("delay", "delay")):
        prepared, extensions = known(category, 1)
        others = [name for name in extensions if name != cause]
        assert held_um(prepared, extensions, list(extensions)) < held_um(prepared, extensions, others)


@pytest.mark.slow
def test_the_size_of_the_hysteresis_is_chosen_by_cross_validation_and_small_under_noise() -> None:
    hidden = scenario("memory", 5)
    prepared, extensions = known("memory", 5)
    y_um = prepared.y_um + 0.1 * np.ptp(prepared.y_um) * np.random.default_rng(2).normal(size=prepared.y_um.size)
    noisy = prepare(Record.from_arrays(hidden.u_V, y_um, hidden.Ts_s))
    sizes = [with_best_forms(one, extensions, ["memory"], USUAL)["memory"].size for one in (prepared, noisy)]
    assert all(size in SIZES for size in sizes)
    assert sizes[1] == SIZES[0]


def delivered(names: list[str]) -> Model:
    """A model as a diagnosis delivers it, with a small hysteresis, which does not change the price of other parts."""
    prepared, _ = known("memory", 8)
    every = {
        "memory": Extension(size=PathSize(plays=4, degree=2, states=0)),
        "aging": Extension(forgetting_s=3.0),
        "outliers": Extension(gate=True),
        "drift": Extension(correction=Trend(1e-9)),
    }
    model = fit_ladder(prepared, every, names, USUAL).model
    assert any(isinstance(block, Hysteresis) for block in model.blocks)
    return add_online_parts(model, [every[name] for name in names], 1.0, 1e-4)


@pytest.mark.parametrize("cause", ["drift", "aging"])
@pytest.mark.slow
def test_the_price_includes_the_terms_and_the_learner_for_operation(cause: str) -> None:
    before, after = price_of(delivered(["memory"])), price_of(delivered(["memory", cause]))
    assert before is not None
    assert after is not None
    assert after.cycles > before.cycles
    assert after.bytes > before.bytes
