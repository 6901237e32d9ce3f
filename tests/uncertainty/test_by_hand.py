"""Figures of a budget, of repeated levels, of a statement of the sensor, calculated by hand."""

import dataclasses
import json
import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy import stats

from hysgen.diagnosis.evaluation import Study
from hysgen.errors import HysgenError
from hysgen.record import Record, Segment
from hysgen.record.noise import NoiseFloor
from hysgen.uncertainty.gum import (
    Budget,
    Contribution,
    SensorUncertainty,
    independent_samples,
    length_um,
    rectangular,
    sensor_uncertainty,
)
from hysgen.uncertainty.simulated import (
    Evidence,
    Repeatability,
    budget,
    characterise,
    error_by_cause,
    holds,
    repeatability,
)


def test_a_budget_is_the_root_of_its_squares_with_students_factor() -> None:
    parts = (
        Contribution("a", 0.3, "A", "x", 4.0, sensitivity=-2.0),
        Contribution("b", 0.8, "B", "y"),
        Contribution("c", 0.1, "A", "z", 12.3),
    )
    found = Budget("m", parts)
    combined = math.sqrt(0.6**2 + 0.8**2 + 0.1**2)
    freedom = combined**4 / (0.6**4 / 4.0 + 0.1**4 / 12.3)
    factor = float(stats.t.ppf(0.975, math.floor(freedom)))
    assert freedom % 1.0 > 0.1
    assert (found.combined_um, found.freedom) == (pytest.approx(combined), pytest.approx(freedom))
    assert (found.factor, found.expanded_um) == (pytest.approx(factor), pytest.approx(factor * combined))
    shares = [f"{100 * v**2 / combined**2:.1f} %" for v in (0.6, 0.8, 0.1)]
    assert found.rows() == [
        ["a", "A", "0.6", "4", shares[0], "x"],
        ["b", "B", "0.8", "inf", shares[1], "y"],
        ["c", "A", "0.1", "12", shares[2], "z"],
    ]
    assert [row[3] for row in Budget("m", (dataclasses.replace(parts[0], freedom=9.96),)).rows()] == ["10"]
    assert [row[3] for row in Budget("m", (dataclasses.replace(parts[0], freedom=9.94),)).rows()] == ["9.9"]
    assert [row[3] for row in Budget("m", (dataclasses.replace(parts[0], freedom=123.0),)).rows()] == ["123"]
    told = json.loads(json.dumps(found.to_json()))
    assert told["contributions"][0] == {
        "name": "a", "standard_um": pytest.approx(0.6), "evaluation": "A", "freedom": 4.0, "about": "x",
    }  # fmt: skip
    assert told["contributions"][1]["freedom"] is None
    assert {key: told[key] for key in ("measurand", "combined_um", "freedom", "coverage", "k", "expanded_um")} == {
        "measurand": "m", "combined_um": found.combined_um, "freedom": found.freedom, "coverage": 0.95,
        "k": found.factor, "expanded_um": found.expanded_um,
    }  # fmt: skip
    certain = Budget("m", parts[1:2], coverage=0.9)
    assert math.isinf(certain.freedom)
    assert certain.factor == pytest.approx(float(stats.norm.ppf(0.95)), rel=1e-9)
    assert certain.to_json()["freedom"] is None
    # Fewer than one degree of freedom count as one.
    assert Budget("m", (Contribution("a", 1.0, "A", "", 0.4),)).factor == pytest.approx(float(stats.t.ppf(0.975, 1)))
    assert Budget("m", (Contribution("a", 0.0, "B", ""),)).rows()[0][4] == ""
    half = rectangular("drift", 0.6, "d")
    assert (half.standard_um, half.evaluation, half.shape) == (pytest.approx(0.6 / math.sqrt(3.0)), "B", "rectangular")


def test_independent_samples_are_counted_up_to_the_first_zero_of_the_correlation() -> None:
    e = np.array([2.0, 3.0, 1.0, -1.0, -2.0, -4.0, 1.0])
    c = e - e.mean()
    rho = [float(c[: 7 - j] @ c[j:]) / float(c @ c) for j in range(7)]
    last = next(j for j in range(7) if rho[j] <= 0.0)
    assert independent_samples((e + 5.0).tolist()) == pytest.approx(7.0 / (1.0 + 2.0 * sum(rho[1:last])))
    assert independent_samples((1e-3 * e).tolist()) == pytest.approx(independent_samples(e.tolist()))
    assert independent_samples([1.0, -1.0]) == 2.0
    assert independent_samples([3.0] * 9) == 9.0
    assert independent_samples([1.0, -1.0, 1.0]) == 3.0


@pytest.mark.parametrize(
    ("text", "um"),
    [("2 m", 2e6), ("3mm", 3e3), ("4um", 4.0), ("4µm", 4.0), ("5nm", 5e-3), ("6e+1 pm", 6e-5)],
    ids=["m", "mm", "um", "micro", "nm", "pm"],
)
def test_a_length_is_read_in_each_unit(text: str, um: float) -> None:
    assert length_um(text) == pytest.approx(um)


def test_a_statement_of_the_sensor_keeps_its_two_numbers_and_refuses_the_rest() -> None:
    assert sensor_uncertainty("5nm,k=2") == SensorUncertainty(0.005, 2.0, "stated: 5nm,k=2")
    assert sensor_uncertainty("5nm") == SensorUncertainty(0.005, 1.0, "stated: 5nm")
    assert sensor_uncertainty("0.1 um, k = 2").standard_um == pytest.approx(0.05)
    for text, said in {
        "5nm,k=two": "the coverage factor 'two' is not a positive number",
        "5nm,k=-1": "the coverage factor '-1' is not a positive number",
        "5nm,k": "'5nm,k' is not LENGTH,k=FACTOR",
        "5nm,=2": "is not LENGTH,k=FACTOR",
        "5nm,k=0": "not a positive",
        **dict.fromkeys(("5", "5V"), "is not a length"),
    }.items():
        with pytest.raises(HysgenError, match=said):
            sensor_uncertainty(text)


def stepped(levels: list[float], places: list[float], samples: int = 40, wiggle_um: float = 0.0) -> Record:
    """Holds of these levels: the first half far off, the last half about its place by +- wiggle."""
    y = [
        np.concatenate([np.full(samples // 2, 9.0), place + wiggle_um * (-1.0) ** np.arange(samples - samples // 2)])
        for place in places
    ]
    u_V = np.repeat(levels, samples)
    return Record.from_segments([Segment("0", u_V, np.concatenate(y))], 1e-3)


def test_repeatability_of_a_small_record_by_hand() -> None:
    levels = [0.0, 10.0, 20.0, 10.0, 0.0, 10.0, 20.0, 10.0, 0.0, 10.0]
    places = [0.0, 1.00, 2.10, 1.30, 0.1, 1.04, 2.12, 1.33, 0.14, 1.09]
    found = repeatability(stepped(levels, places, wiggle_um=0.001))
    # 10 V from below three times, 10 V from above, 20 V and 0 V twice.
    visits = ([1.00, 1.04, 1.09], [1.30, 1.33], [2.10, 2.12], [0.1, 0.14])
    power = sum(float(np.sum((np.array(y) - np.mean(y)) ** 2)) for y in visits)
    assert found == Repeatability(pytest.approx(math.sqrt(power / 5)), 5, 10)  # type: ignore[arg-type]
    assert found.to_json() == dataclasses.asdict(found)
    assert repeatability(stepped([0.0, 1.0, 0.0], [0.0, 1.0, 0.2])) == Repeatability(None, 0, 3)


def test_a_hold_lasts_ten_milliseconds_and_sixteen_samples() -> None:
    for samples, Ts_s, counted in ((15, 1e-3, False), (16, 1e-3, True), (99, 1e-4, False), (100, 1e-4, True)):
        u_V = np.concatenate([np.full(samples, 1.0), np.linspace(2.0, 3.0, 20)])
        found = holds(Record.from_segments([Segment("0", u_V, 0.1 * u_V)], Ts_s))
        assert [hold.u_V for hold in found] == ([1.0] if counted else [])


PLAIN = Evidence(
    np.array([0.3, -0.3, 0.5, -0.5, 0.1, -0.1]),
    NoiseFloor(0.1, "spectra", 9),
    400,
    16,
    SensorUncertainty(0.2, 2.0, "s"),
)


def test_a_budget_of_a_simulation_by_hand() -> None:
    power = (0.09 + 0.25 + 0.01) / 3.0
    cycle = Repeatability(0.2, 7, 4)
    found = budget(dataclasses.replace(PLAIN, repeatability=cycle, drift_um=0.3))
    lines = {c.name: c for c in found.contributions}
    assert list(lines) == ["sensor", "noise", "repeatability", "model error", "drift"]
    assert (lines["sensor"].standard_um, lines["sensor"].evaluation, lines["sensor"].about) == (0.1, "B", "s")
    assert (lines["noise"].standard_um, lines["noise"].freedom) == (pytest.approx(0.1 * math.sqrt(16 / 400)), 384.0)
    assert lines["noise"].about == "0.1 um a reading; 16 parameters, 400 rows"
    assert (lines["repeatability"].standard_um, lines["repeatability"].freedom) == (pytest.approx(0.2), 7.0)
    assert lines["repeatability"].about == "levels that the record visits again, 4 holds"
    assert lines["model error"].standard_um == pytest.approx(math.sqrt(power - 0.01 - 0.04))
    assert lines["model error"].freedom == independent_samples(PLAIN.residual_um.tolist()) - 1.0
    assert lines["model error"].about == "held-out free run over 6 rows, less noise and repeatability"
    assert lines["drift"].standard_um == pytest.approx(0.3 / math.sqrt(3.0))
    assert lines["drift"].about == "at most 0.3 um since the record"
    assert found.measurand == "displacement that the model states for a sample (free run)"
    for rows, counted in ((2, 2), (1, 1), (0, 1)):
        one = budget(dataclasses.replace(PLAIN, fitted=rows)).contributions[1]
        assert (one.standard_um, one.freedom) == (pytest.approx(0.1 * math.sqrt(16 / counted)), 1.0)
    # Neither noise nor repeated visits count for more than the residual has.
    loud = budget(dataclasses.replace(PLAIN, noise=NoiseFloor(9.0, "spectra", 9), fitted=10, repeatability=cycle))
    named = {c.name: c for c in loud.contributions}
    assert (named["model error"].standard_um, named["noise"].freedom) == (0.0, 1.0)
    assert "repeatability" not in named
    wide = budget(dataclasses.replace(PLAIN, repeatability=dataclasses.replace(cycle, spread_um=5.0, freedom=0)))
    spread = next(c for c in wide.contributions if c.name == "repeatability")
    assert (spread.standard_um, spread.freedom) == (pytest.approx(math.sqrt(power - 0.01)), 1.0)


def test_the_model_error_follows_orthogonal_actions() -> None:
    e = np.array([1.0, 2.0, 3.0, 4.0])
    a, b = np.array([1.0, 0.0, 0.0, 0.0]), np.array([2.0, 1.0, 0.0, 0.0])
    slanted = error_by_cause(e, [("c", np.ones(4)), ("d", np.array([0.0, 2.0, 0.0, 0.0]))])
    assert [part for _, part in slanted] == pytest.approx([(10.0 / 2.0) ** 2 / 4, (-0.5 / math.sqrt(0.75)) ** 2 / 4])
    assert error_by_cause(e, [("a", a), ("again", 3.0 * a), ("b", b)]) == [
        ("a", pytest.approx(1.0 / 4)),
        ("again", 0.0),
        ("b", pytest.approx(4.0 / 4)),
    ]
    quiet = dataclasses.replace(PLAIN, residual_um=e, noise=NoiseFloor(0.0, "spectra", 9))
    found = budget(dataclasses.replace(quiet, actions_um=(("a", a),), left_um=(("drift", 1.5),)))
    parts = {c.name: c for c in found.contributions[2:]}
    assert {name: c.standard_um**2 for name, c in parts.items()} == {
        "model error, a": pytest.approx(0.25),
        "model error, drift": pytest.approx(2.25),
        "model error, rest": pytest.approx(7.5 - 2.5),
    }
    freedom = max(1.0, independent_samples(e.tolist()) - 1.0)
    assert parts["model error, drift"].freedom == pytest.approx(freedom * 2.25 / 7.5)
    assert parts["model error, a"].about == "still follows the action of its extension"
    assert parts["model error, drift"].about == "named; its extension, not in the model, would remove it"
    # Causes that claim more than there is share what there is.
    much = budget(dataclasses.replace(quiet, left_um=(("creep", 3.0), ("drift", 4.0))))
    claimed = {c.name: c.standard_um**2 for c in much.contributions[2:]}
    assert claimed["model error, creep"] == pytest.approx(7.5 * 9 / 25)
    assert claimed["model error, drift"] == pytest.approx(7.5 * 16 / 25)
    assert claimed["model error, rest"] == pytest.approx(0.0, abs=1e-12)


def test_a_characterisation_takes_its_evidence_from_the_diagnosis() -> None:
    """Stand-ins for a study: error traces of two extensions, a cause named and refused, and held-out rows 2 .. 5."""
    base, one, two = (np.array(v) for v in ([9.0, 9, 4, 1, 3, 2], [9.0, 9, 1, 2, 1, 1], [9.0, 9, 0.5, 0.25, -0.5, 1]))
    cause = lambda name, **more: SimpleNamespace(name=name, **more)  # noqa: E731
    first = cause("memory", extended=True, step=SimpleNamespace(after_um=3.0))
    second = cause("creep", extended=True, step=SimpleNamespace(after_um=3.5))
    left = cause("drift", extended=False, alone=SimpleNamespace(before_um=0.5, after_um=0.3))
    worse = cause("aging", extended=False, alone=SimpleNamespace(before_um=0.3, after_um=0.5))
    bare = cause("delay", extended=False, alone=None)
    record = stepped([0.0, 1.0, 0.0], [0.0, 1.0, 0.1])
    rows = np.arange(2, 6)
    model = SimpleNamespace(consequents=np.zeros((4, 3)), weights=np.zeros(2))
    diagnosis = SimpleNamespace(
        held_rows=rows, model=model, noise=NoiseFloor(0.01, "spectra", 9), base_own_um=5.0,
        errors_um=[("", base), ("memory", one), ("creep", two)], causes=(first, second, left, worse, bare),
    )  # fmt: skip
    study = cast(Study, SimpleNamespace(diagnosis=diagnosis, record=record, cut=100, extended=(first, second)))
    found = characterise(study, SensorUncertainty(0.2, 2.0, "s"))
    evidence = Evidence(
        two[rows], NoiseFloor(0.01, "spectra", 9), 100, 14, SensorUncertainty(0.2, 2.0, "s"), repeatability(record),
        actions_um=(("memory", (one - base)[rows]), ("creep", (two - one)[rows])),
        left_um=(("drift", 0.4), ("aging", 0.0)),
    )  # fmt: skip
    assert found.budget.to_json() == budget(evidence).to_json()
    assert found.removed == (("memory", 4.0), ("creep", 0.0))
    assert [line.partition(":")[0] for line in found.missing] == ["drift since the record", "repeatability"]
    told = found.to_json()
    assert told["removed_by_extension_um"] == {"memory": 4.0, "creep": 0.0}
    assert (told["missing"], told["repeatability"]) == (list(found.missing), repeatability(record).to_json())
    lines = found.lines()
    b = found.budget
    assert f"U = {b.expanded_um:.3g} um (k = {b.factor:.3g}, 95 %, {b.freedom:.0f} degrees of freedom), " in lines[0]
    assert lines[0].endswith(f"u_c = {b.combined_um:.3g} um")
    wide = max(len(c.name) for c in b.contributions)
    for line, (name, kind, value, _, share, about) in zip(lines[1:], b.rows(), strict=False):
        assert line == f"    {name.ljust(wide)}  {kind}  {value.rjust(9)} um  {share.rjust(7)}  {about}"
    assert lines[-2:] == [f"    not known: {line}" for line in found.missing]
    known = characterise(study, SensorUncertainty(0.2, 2.0, "s"), 0.5)
    assert [line.partition(":")[0] for line in known.missing] == ["repeatability"]
    assert known.budget.contributions[-1].name == "drift"
