"""Figures of the studies, from made-up runs: each printed number and each rate against a calculation by hand."""

import dataclasses
import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import hysgen
from hysgen.errors import HysgenError
from hysgen.model.scores import Score
from hysgen.report.words import price_of
from hysgen_lab.studies.bank.log import JudgementLog, read_log
from hysgen_lab.studies.bank.result import BankResult, Judgement
from hysgen_lab.studies.bank.scenario import CATEGORIES, NUMBERS, good, poor, random_levels, scenario
from hysgen_lab.studies.paper.experiments import CASES, EXPERIMENTS, PublishedTracking, RepeatedExperiment, Tracking
from hysgen_lab.studies.paper.learning import GainLoss, LearnerAgreement
from hysgen_lab.studies.paper.results import PaperResults

TRACKED = Tracking(
    50.0,
    PublishedTracking(18.6, 3.14),
    np.arange(3.0),
    np.array([2.0, 2.5, 1.5]),
    {"a": np.array([2.1, 2.5, 1.3]), "b": np.array([2.0, 2.4, 1.5])},
)
LOSS = GainLoss("falls", 0.1, 0.4, np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.16, 0.15]), 5, 2, 1)


def test_tracking_and_learning_are_scored_by_their_definitions() -> None:
    assert TRACKED.e_rms_nm == pytest.approx({"a": 1e3 * math.sqrt(0.05 / 3), "b": 1e3 * math.sqrt(0.01 / 3)})
    assert TRACKED.e_r_percent == pytest.approx({"a": 100 * 0.2 / 2.5, "b": 100 * 0.1 / 2.4})
    published = {"e_rms_nm": 18.6, "e_r_percent": 3.14, "proportional_percent": 18.0}
    assert TRACKED.to_json() | {"published": published} == TRACKED.to_json()
    assert (TRACKED.to_json()["e_rms_nm"], TRACKED.to_json()["f_Hz"]) == (TRACKED.e_rms_nm, 50.0)
    assert [(case.f_Hz, case.published.e_rms_nm, case.published.e_r_percent) for case in CASES] == [
        (50.0, 18.6, 3.14),
        (100.0, 15.2, 2.91),
    ]
    assert LOSS.caught_up_s == 0.3
    assert dataclasses.replace(LOSS, before_um=1.0).caught_up_s == 0.1
    assert dataclasses.replace(LOSS, before_um=0.09).caught_up_s is None
    told = LOSS.to_json()
    assert told == {
        "what": "falls", "before_um": 0.1, "stale_um": 0.4, "committed": 5, "refused": 2, "unsafe": 1,
        "caught_up_s": 0.3, "final_um": 0.15,
    }  # fmt: skip
    found = LearnerAgreement("t", 0.004, 0.005)
    assert found.excess == pytest.approx(0.25)
    assert found.to_json() == {"title": "t", "float64_um": 0.004, "learned_um": 0.005, "excess": found.excess}


def test_tables_of_the_paper_hold_every_figure() -> None:
    scores = {name: Score(0.1 * i, 1.0, 1.5 * i, 0.0, 9) for i, name in enumerate("abcdefgh", start=1)}
    stub = lambda free, **more: SimpleNamespace(free_run=free, to_json=lambda: {"e": free.e_rms_um}, **more)  # noqa: E731
    paper = stub(scores["a"], one_step=scores["b"], persistence=scores["c"], noise=SimpleNamespace(rms_um=0.0123))
    outcome = RepeatedExperiment(
        EXPERIMENTS[0], cast(Any, None), {},
        cast(Any, {"paper": paper, "refined": stub(scores["d"]), "memory": stub(scores["e"])}),
        {"memory": scores["f"]}, (("ARX", scores["g"]), ("none", Score(0.8, 1.0, None, 0.0, 9))),
    )  # fmt: skip
    results = PaperResults((outcome,), (TRACKED,), (LearnerAgreement("t", 0.004, 0.005),), (LOSS,))
    modelling, tracking, learning, changes = (part.splitlines() for part in results.text().split("\n\n"))
    rows = [line.rsplit(maxsplit=2) for line in modelling[3:]]
    assert [(a.strip(), b, c) for a, b, c in rows[:-2]] == [
        ("paper, one step", "0.0016", "0.31"),
        ("ours, one step", "0.2000", "3.00"),
        ("persistence, one step", "0.3000", "4.50"),
        ("ours, free run", "0.1000", "1.50"),
        ("ours, refined, free run", "0.4000", "6.00"),
        ("ours, refined, with memory, free run", "0.5000", "7.50"),
        ("the same, after the first 20 ms", "0.6000", "9.00"),
        ("ARX, free run", "0.7000", "10.50"),
        ("none, free", "run", "0.8000"),
    ]
    assert modelling[-2].split()[-2:] == ["0.1722", "10.79"]
    assert modelling[-1].split()[-1] == "0.0123"
    assert tracking[2].strip() == "Section 4.3: y_d = 2.0 + 0.6 sin(2 pi 50 t) um"
    assert [line.split()[-2:] for line in tracking[3:]] == [
        ["18.6", "3.14"],
        ["about", "18"],
        ["129.1", "8.00"],
        ["57.7", "4.17"],
    ]
    assert learning[2].split() == ["t", "4.0000", "5.0000", "+25.000", "%"]
    assert changes[2].split() == ["falls", "100.0", "400.0", "150.0", "0.30", "5", "2", "1"]
    never = dataclasses.replace(results, changes=(dataclasses.replace(LOSS, before_um=0.09),))
    assert " never " in never.text().splitlines()[-1]
    told = json.loads(json.dumps(results.to_json()))
    assert told["modelling"][0] == {
        "experiment": "4.1", "published": {"e_rms_um": 0.0016, "e_r_percent": 0.31},
        "variants": {"paper": {"e": 0.1}, "refined": {"e": 0.4}, "memory": {"e": 0.5}},
        "free_run_after_first_excursion": {"memory": scores["f"].to_json()},
        "rivals_free_run": {"ARX": scores["g"].to_json(), "none": {**scores["h"].to_json(), "e_r_percent": None}},
    }  # fmt: skip
    assert (told["tracking"], told["changes"]) == ([TRACKED.to_json()], [LOSS.to_json()])


LAST = {"creep.share": 1.0, "drift.ramp": 0.5}


def judged(seed: int, named: tuple[str, ...], relative: float, **more: Any) -> Judgement:
    given = {"category": "creep", "rate_Hz": 1e3, "excitation": "good", "planted": ("creep",), "required": ("creep",)}
    return Judgement(
        **(given | {"errors": {"creep.share": -0.1 * seed}, "seconds": float(seed), "experiment": ""} | more),
        seed=seed, named=named, relative={"creep": relative},
    )  # fmt: skip


def test_results_of_the_bank_are_counted_and_come_back_from_their_log(tmp_path: Path) -> None:
    records = (
        judged(1, (), 2.0, family="thermal", over_probe=3.0, gain=10.0),
        judged(
            2,
            ("creep",),
            3.0,
            over_probe=1.2,
            gain=20.0,
            fall=8.0,
            over_truth=1.5,
            confidence={"creep": 0.9},
            ranks={"creep.share": 0.3},
        ),
        judged(4, ("creep", "drift"), 5.0, fall=6.0, confidence={"creep": 1.0, "drift": 0.95}, ranks=LAST),
        judged(9, ("drift",), 9.0, category="poor", family="tilt"),
    )
    result = BankResult(records, (1, 9), 5)
    assert not result.complete
    assert (result.exact_rate, result.found_rate) == (pytest.approx(1 / 3), pytest.approx(2 / 3))
    assert (result.smallest(0.5), result.smallest(0.95)) == ({"creep": 2.0}, {"creep": 3.0})
    assert result.parameter_errors() == {"creep.share": (pytest.approx(0.2), pytest.approx(0.4), 3)}
    assert result.ranks() == {"creep.share": (0, 1, 0, 1)}
    by_hand = (-(2.0 * np.log(0.8) + np.log(0.2)) / 3.0, (0.1**2 + 0.95**2) / 3.0)
    assert result.scores() == pytest.approx(by_hand)
    assert result.calibration() == [(0.0, 0, 0), (0.9, 2, 1), (0.99, 0, 0), (0.999, 1, 1)]
    assert (result.falls(), result.over_truth()) == ([6.0, 8.0], [1.5])
    assert [one.difference() for one in records[:3]] == ["lacks creep (2)", "exact", "adds drift"]
    told = json.loads(json.dumps(result.to_json()))
    assert (told["records"], told["seeds"], told["median_seconds"]) == (4, [1, 9], 3.0)
    assert [(wrong["seed"], wrong["family"]) for wrong in told["wrong"]] == [(1, "thermal"), (4, "")]
    assert told["families"] == {
        "thermal": {"records": 1, "exact_rate": 0.0, "found_rate": 0.0},
        "": {"records": 2, "exact_rate": 0.5, "found_rate": 1.0},
        "tilt": {"records": 0, "exact_rate": None, "found_rate": None},
    }
    assert told["false_alarm_rate"] is None
    assert told["categories"] == {
        "creep": {"records": 3, "exact": 1, "over_probe": {"median": pytest.approx(2.1), "largest": 3.0},
                  "largest_in": "thermal creep 1", "gain": 15.0},
        "poor": {"records": 1, "exact": 0, "over_probe": {"median": None, "largest": None},
                 "largest_in": None, "gain": None},
    }  # fmt: skip
    path = tmp_path / "a" / "log"
    for record in records:
        JudgementLog(path).add(record)
    path.write_bytes(path.read_bytes() + b'{"category": "cut of')
    assert len(read_log(path)) == 4
    JudgementLog(path).add(records[0])
    again = read_log(path)
    known = dict.fromkeys(("fall", "over_truth", "over_probe", "gain"), 0.0)
    assert [dataclasses.replace(one, **known) for one in again[:4]] == [
        dataclasses.replace(one, **known) for one in records
    ]
    assert [one.fall for one in again[1:3]] == [8.0, 6.0]
    assert [one.over_probe for one in again[:2]] == [3.0, 1.2]
    assert math.isnan(again[0].fall)
    path.write_text(path.read_text().replace('"seed": 2', '"other": 2'))
    with pytest.raises(HysgenError, match="row 3: not a judgement"):
        read_log(path)


def test_commands_of_the_bank_fill_their_range_and_seeds_never_move() -> None:
    """The numbers of the categories seed their scenarios: a change would replace every record of the bank."""
    assert {name: NUMBERS[name] for name in ("pair", "memory", "none", "poor")} == {
        "pair": 10, "memory": 11, "none": 12, "poor": 14,
    }  # fmt: skip
    assert len(set(NUMBERS.values())) == len(CATEGORIES)
    rng = np.random.default_rng(0)
    for low, high in ((0.0, 100.0), (-20.0, 50.0)):
        wave = good(rng, 5000, low, high)
        assert wave.size == 5000
        assert (wave.min(), wave.max()) == (pytest.approx(low, abs=0.5), pytest.approx(high, abs=0.5))
        for kind, part in (("one sine", 1.0), ("small strokes", 0.03), ("slow triangle", 1.0)):
            u = poor(kind, rng, 5000, low, high)
            assert np.ptp(u) == pytest.approx(part * (high - low), rel=0.01)
            assert (u.max() + u.min()) / 2 == pytest.approx((low + high) / 2, abs=0.5)
    levels = random_levels(rng, 3000, 10.0, 20.0)
    assert (levels.size, 10.0 <= levels.min() < 11.0, 19.0 < levels.max() <= 20.0) == (3000, True, True)
    hidden = scenario("creep", 3)
    assert 6000 <= len(hidden.u_V) <= 9000
    noise = hidden.stage.noise
    assert noise is not None
    assert 2e-5 <= noise.white_um / hidden.stage.stroke_um <= 5e-4


@pytest.mark.slow
def test_the_price_of_a_model_is_that_of_its_generated_c() -> None:
    model = hysgen.load_model("appendix_a")
    for one in (model, hysgen.firmware_files(model).model):
        code = hysgen.generate(one)
        cost, price = hysgen.cost(code).to_json(), price_of(one)
        structs = cost["bytes"]["structs"]
        held = structs[f"{one.name}_t"] + structs.get(f"{one.name}_learner_t", 0)
        assert price is not None
        assert (price.cycles, price.bytes) == (cost["per_sample"]["value"], held + cost["bytes"]["constants"])
