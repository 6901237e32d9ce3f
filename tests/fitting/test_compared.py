"""Comparison of two models and verdict on a refit, against the closed form of a linear lag."""

import dataclasses
import json

import numpy as np
import pytest

from fixtures.random_models import lag_record, random_model
from hysgen.errors import ModelError
from hysgen.fitting import FitSettings, PathSize
from hysgen.fitting import refit as refitting
from hysgen.fitting.refine import Criterion, FreeRunError, refine
from hysgen.fitting.refit import (
    Change,
    Comparison,
    compare,
    loop_frequencies,
    physics,
    restricted_as,
    settings_of,
    structure_fits,
)
from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.model import Grid, Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.limits import Saturation
from hysgen.model.scores import score

TS_S, A, C = 2e-5, 0.98, 0.02
TERMS = (Periodic((50.0,)), Drift(0.01, 0.05))


def lag(name: str, b: float = 0.0016, a: float = A, weights: tuple[float, ...] = (0.0, 0.0, 1.0)) -> Model:
    consequents = np.tile([a, b, C], (6, 1))
    return Model(name, TS_S, Grid(-5.0, 15.0, 6), consequents, 0.0, 100.0, TERMS, np.array(weights))


def response(f_Hz: float, a: float, b: float) -> complex:
    """Of y(k+1) = a y(k) + b u(k), at the nearest whole number of samples per period."""
    period = round(1.0 / (f_Hz * TS_S))
    return complex(b / (np.exp(2j * np.pi / period) - a))


@pytest.mark.parametrize(("a", "b"), [(0.98, 0.0016), (0.95, 0.003)])
def test_physics_of_a_linear_lag_are_its_closed_form(a: float, b: float) -> None:
    model = dataclasses.replace(lag("m", b, a), u_min_V=10.0, u_max_V=90.0)
    tau_s = -TS_S / np.log(a)
    corner = 1.0 / (2 * np.pi * tau_s)
    slow, fast = loop_frequencies(model)
    # Both stay below a 20th of the sampling rate, the fast loop at it and the slow one at a 30th of that.
    assert slow == pytest.approx(min(0.01 * corner, 0.01 / 0.3 / (20 * TS_S)))
    assert fast == pytest.approx(min(0.3 * corner, 1.0 / (20 * TS_S)))
    found = {what: (unit, value) for what, unit, value in physics(model, [slow, fast])}
    expected = {
        "DC gain, mid-range": ("um/V", b / (1 - a)),
        "time constant, mid-range": ("ms", 1e3 * tau_s),
        "at rest at the lowest input": ("um", (10 * b + C) / (1 - a)),
        "at rest at the highest input": ("um", (90 * b + C) / (1 - a)),
        "periodic: sum of its 2 weights": ("", 0.0),
        "drift: sum of its 1 weights": ("", 1.0),
    }
    for f in (slow, fast):
        h = response(f, a, b)
        # An ellipse of 36 V has the area pi 36^2 |Im h|; it opens by that over 72 V.
        expected[f"loop width at {f:.3g} Hz, mean"] = ("um", np.pi * 36 * abs(h.imag) / 2)
        expected[f"gain at {f:.3g} Hz"] = ("um/V", abs(h))
    assert found.keys() == expected.keys()
    for what, (unit, value) in expected.items():
        assert found[what] == (unit, pytest.approx(value, rel=2e-3)), what


@pytest.mark.slow
def test_a_comparison_has_the_numbers_of_both_models_in_text_and_json() -> None:
    old, new = lag("old"), lag("later", 0.0018, weights=(1e-4, 2e-4, 1.5))
    new = dataclasses.replace(new, grid=Grid(-5.0, 16.0, 6))
    record = lag_record(samples=400)
    found = compare(old, new, [record])
    frequencies = loop_frequencies(old)
    changes = {change.what: change for change in found.changes}
    assert (changes["displacement, low end"].old, changes["displacement, low end"].new) == (-5.0, -5.0)
    high = changes["displacement, high end"]
    assert (high.unit, high.old, high.new, high.percent) == ("um", 15.0, 16.0, pytest.approx(100 / 15))
    # Old and new stand for the same property at the frequencies of the old model.
    for place, model in ((lambda change: change.old, old), (lambda change: change.new, new)):
        assert [(c.what, c.unit, place(c)) for c in found.changes[2:]] == physics(model, frequencies)
    sums = [(c.old, c.new) for c in found.changes if "sum of" in c.what]
    assert sums == [(0.0, pytest.approx(3e-4)), (1.0, 1.5)]
    assert found.rules == ((0.0, pytest.approx(0.0002), 0.0),) * 6
    assert found.centres_um == tuple(zip((-5.0, -1.0, 3.0, 7.0, 11.0, 15.0), np.linspace(-5, 16, 6), strict=True))
    errors = tuple(score(model, record).free_run.e_rms_um for model in (old, new))
    assert found.scores == (("lag", *errors),)
    told = json.loads(json.dumps(found.to_json()))
    assert told["free_run_rms_um"] == [{"record": "lag", "old": errors[0], "new": errors[1]}]
    assert (told["old"], told["new"]) == ("old", "later")
    assert told["changes"][1] == dataclasses.asdict(high) | {"percent": high.percent}
    assert told["centres_um"] == [list(pair) for pair in found.centres_um]
    assert told["rules_change"] == [list(rule) for rule in found.rules]


def test_a_comparison_is_written_with_signs_units_and_the_number_of_each_rule() -> None:
    changes = (Change("gain", "um/V", -2.0, -2.5), Change("sum", "", 0.0, 1.0))
    found = Comparison(
        "a", "b", changes, ((1.0, 1.5), (2.0, 2.5)), ((0.25, -0.5, 0.0), (1.0, 2.0, 3.0)), (("r", 0.5, 0.25),)
    )
    first, second = found.text("heading").split("\n\n")
    cells = [[cell for cell in line.split("  ") if cell] for line in first.splitlines()]
    assert [cell.strip() for cell in cells[0]] == ["heading", "old", "new", "change"]
    assert [cell.strip() for cell in cells[2]] == ["gain [um/V]", "-2", "-2.5", "-25.0 %"]
    assert [cell.strip() for cell in cells[3]] == ["sum", "0", "1"]
    assert [cell.strip() for cell in cells[4]] == ["free run on r [um rms]", "0.5", "0.25"]
    rules = [line.split() for line in second.splitlines()]
    assert rules[0] == ["rule", "centre", "[um]", "q1", "[um/um]", "q2", "[um/V]", "q3", "[um]"]
    assert rules[2] == ["1", "1", "->", "1.5", "+0.25", "-0.5", "+0"]
    assert rules[3] == ["2", "2", "->", "2.5", "+1", "+2", "+3"]
    assert found.text().startswith("a -> b")
    assert found.summary().title == "a -> b"


def test_models_with_other_terms_blocks_or_rules_are_not_compared() -> None:
    old = lag("old")
    other = dataclasses.replace(old, name="two", terms=TERMS[:1], weights=np.zeros(2), blocks=(Saturation(0.0, 90.0),))
    said = r"old and two: structures differ \(6 rules, periodic of 2, drift of 1 against 6 rules, periodic of 2, satur"
    with pytest.raises(ModelError, match=said):
        compare(old, other)
    with pytest.raises(ModelError, match=r"structures differ \(6 rules, .* against 5 rules, "):
        compare(old, dataclasses.replace(old, grid=Grid(-5.0, 15.0, 5), consequents=old.consequents[:5]))


@pytest.mark.parametrize(
    ("percent", "e_um", "fits"), [(1.499, 9.0, True), (1.501, 9.0, False), (9.0, 0.01399, True), (9.0, 0.01401, False)]
)
def test_a_structure_fits_within_half_more_of_the_old_error_or_near_the_noise(
    percent: float, e_um: float, fits: bool
) -> None:
    model, record = lag("m"), lag_record(samples=400)
    scores = score(model, record)
    free = dataclasses.replace(scores.free_run, of_span_percent=percent, e_rms_um=e_um)
    scores = dataclasses.replace(scores, free_run=free, noise=dataclasses.replace(scores.noise, rms_um=0.01))
    before = dataclasses.replace(model, scores={"identification": {"free_run": {"of_span_percent": 1.0}}})
    found, line = structure_fits(before, scores)
    assert found is fits
    verdict = "still fits" if fits else "NO LONGER FITS"
    assert line == f"{verdict} (free run {percent:.3g} % of the stroke, 1 % before, noise 0.01 um)"
    unknown = structure_fits(model, scores)
    assert unknown == (
        True,
        f"free run {percent:.3g} % of the stroke; the old model has no score of its own to compare with",
    )


def test_a_refit_keeps_every_narrower_limit() -> None:
    old = lag("old").within((0.0, 10.0), (10.0, 90.0))
    new = dataclasses.replace(lag("later"), scores={"x": 1}, certificates={"y": 2})
    both = restricted_as(old, new)
    assert (both.grid.y_min_um, both.grid.y_max_um, both.u_min_V, both.u_max_V) == (0.0, 10.0, 10.0, 90.0)
    assert (both.scores, both.certificates) == ({}, {})
    narrow = dataclasses.replace(lag("n", 0.001), u_min_V=20.0, u_max_V=80.0, scores={"x": 1})
    assert restricted_as(old, narrow.within((1.0, 9.0))).grid.ends_um == narrow.grid.ends_um
    assert restricted_as(lag("wide"), narrow) is narrow
    only_volts = restricted_as(lag("old").within(None, (30.0, 60.0)), narrow)
    assert (only_volts.u_min_V, only_volts.u_max_V, only_volts.grid) == (30.0, 60.0, narrow.grid)


def test_settings_of_a_model_are_those_of_its_fit_with_its_structure() -> None:
    block = Hysteresis(0.0, 100.0, (5.0, 4.0), (0.1, 0.3), (0.5, 0.5))
    stored = {"fit": {"rules": 99, "forgetting": 0.9, "unknown": 3, "memory": {"plays": 5}}}
    model = dataclasses.replace(lag("m"), blocks=(Saturation(0.0, 90.0), block), history=stored)
    found = settings_of(model)
    assert (found.name, found.rules, found.forgetting, found.input_range_V) == ("m", 6, 0.9, (0.0, 100.0))
    assert (found.terms, found.blocks, found.memory) == (TERMS[:1], (Saturation(0.0, 90.0),), PathSize(plays=5))
    with pytest.raises(ModelError, match="m: the model file does not say how it was fitted"):
        settings_of(lag("m"))


def test_a_refit_keeps_the_range_on_request_and_a_drift_in_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit is a stand-in that returns what it was asked for; its other results are tested with real fits."""
    record = lag_record(samples=400)
    old = dataclasses.replace(lag("m"), u_max_V=50.0, history={"fit": {"margin": 0.2}})
    asked: list[FitSettings] = []

    def fitted(record: object, settings: FitSettings, **options: object) -> Model:
        asked.append(settings)
        return dataclasses.replace(lag("m"), terms=TERMS[:1], weights=1e-5 * np.array([2.0, 3.0]))

    monkeypatch.setattr(refitting, "fit", fitted)
    again, scores = refitting.refit(old, record, same_range=True)
    assert (asked[0].margin, asked[0].displacement_range_um) == (0.0, (-5.0, 15.0))
    assert asked[0].input_range_V == (0.0, max(50.0, record.u_range_V[1]))
    assert again.terms == old.terms
    assert again.weights.tolist() == pytest.approx([2e-5, 3e-5, 1.0])
    assert (again.u_min_V, again.u_max_V) == (0.0, 50.0)
    assert again.scores["identification"] == scores.to_json()
    assert again.certificates["gain"]["holds"]
    refitting.refit(old, record)
    assert (asked[1].margin, asked[1].displacement_range_um) == (0.2, None)


class FallingError(FreeRunError):
    """J falls by 1 % with each step while the free-run error rises: what penalties may do."""

    def criterion(self, model: Model) -> Criterion:
        moved = float(np.abs(model.parameters - 0.0).sum())
        size = model.parameters.size
        return Criterion(1.0 / (1.0 + moved), -np.ones(size), np.eye(size), 1.0 + 0.01 * min(moved, 1.0))


def test_a_refinement_never_ends_above_its_start() -> None:
    start = random_model(1).with_parameters(np.zeros(18))
    found = refine(start, FallingError(lag_record(samples=100), (), ()), None, iterations=3)
    assert found.criterion.rms_um == 1.0
    np.testing.assert_array_equal(found.model.parameters, start.parameters)
    assert found.steps == 0
