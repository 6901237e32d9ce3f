"""A diagnosis with made-up numbers in words and cells: every number stands where it belongs, by hand."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from fixtures.made_up_study import (
    BASE,
    BOTH,
    COST,
    CREEP,
    CUT,
    EQUAL,
    HUM,
    MISMATCH,
    STEP,
    T_S,
    TS_S,
    U_V,
    WRONG,
    Y_UM,
    N,
    cause,
    cells,
    left,
    lines_of,
    model,
    scored,
    study,
)
from fixtures.random_models import random_model
from fixtures.term_models import model_with
from hysgen.diagnosis.answer import Price, Refused
from hysgen.diagnosis.causes import Estimate
from hysgen.diagnosis.identifiability import Ability
from hysgen.errors import BudgetError
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.scores import Score
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor
from hysgen.report import plots, words
from hysgen.report.page import (
    TERMS,
    cost_section,
    equivalence_section,
    model_section,
    uncertainty_section,
)
from hysgen.report.pages import diagnosis_page, file_names, key_figures, model_page
from hysgen.uncertainty.gum import Budget, Contribution

# In words


def test_verdict_of_two_causes_states_size_shares_gain_and_price() -> None:
    wrong = "The simulation is wrong by 6.2 % of the stroke: 0.5 um rms in free run, held out; the noise is 0.01 um."
    gain = "in the model: 1.2 %, 0.1 um, 5 times less, for about 33 more cycles a sample and 36 more bytes."
    share = "Of that error (of its power above the noise)"
    assert words.verdict(BOTH) == [wrong, f"{share} periodic is 80 % and creep is 15 %.", f"With both {gain}",
                                    left(0.1).line()]  # fmt: skip
    turned = study(dataclasses.replace(HUM, share=0.1), CREEP, unknown="a jump")
    assert words.verdict(turned)[1:] == [
        f"{share} creep is 15 % and periodic is 10 %.", f"With both {gain}", left(0.1).line(),
        "None of the known causes explains the following: a jump.",
    ]  # fmt: skip
    small = [dataclasses.replace(CREEP, share=value) for value in (0.004, 0.005)]
    ends = ["creep less than 1 %", "creep is 0 %"]
    assert [words.verdict(study(HUM, one))[1] for one in small] == [f"{share} periodic is 80 % and {e}." for e in ends]
    assert words.verdict(study(HUM))[2].startswith("With it in the model: 2.5 %, 0.2 um, 2.5 times less, for about 40 ")
    third = study(HUM, CREEP, dataclasses.replace(CREEP, name="drift", share=0.02, price=None))
    assert words.verdict(third)[1:] == [
        f"{share} periodic is 80 %, creep is 15 % and drift is 2 %.",
        "With all of them in the model: 1.2 %, 0.1 um, 5 times less.",
        left(0.1).line(),
    ]
    assert words.total_price(third) is None
    assert words.total_price(BOTH) == Price(33, 36)


def test_verdict_without_an_extension_says_why() -> None:
    assert words.verdict(study())[0].endswith(
        "\nLeft: 0.5 um, 50 times the noise; a finer model (the probe) leaves 0.02 um on the same rows: it is the form."
    )
    assert words.verdict(study())[1:] == [
        "No cause stands out: it is what the paper's model leaves of plain hysteresis, and noise."
    ]
    assert "none of the known causes explains: a jump." in words.verdict(study(unknown="a jump"))[1]
    refused = (Refused("creep", "too slow"), Refused("drift", "too small"))
    assert words.verdict(study(refused=refused))[1] == (
        "No cause is certain, and the error is 50 times the noise. Not named: creep: too slow; drift: too small."
    )
    # 5 times the noise is not yet far above it.
    for noise_um, far in ((0.1, False), (0.0999, True)):
        said = words.verdict(study(refused=refused, noise=NoiseFloor(noise_um, "periods", 1)))[1]
        assert said.startswith("No cause is certain") == far
    lost = dataclasses.replace(HUM, extended=False)
    assert words.verdict(study(lost, unknown="a jump"))[1:] == [
        "The model written is the paper's: no extension lowers the error on rows left out of the fit for certain.",
        left(0.5).line(), f"{lost.why_not_extended}.", "None of the known causes explains the following: a jump.",
    ]  # fmt: skip
    deviation = float(np.std(Y_UM[CUT:]))
    for part, useless in ((0.89, False), (0.91, True)):
        said = words.verdict(study(remaining=left(part * deviation)))[1]
        assert said.startswith("A constant is as good as every model here of the displacement: a linear") == useless
    record = Record.from_arrays(U_V, 0.1 * np.roll(np.random.default_rng(3).normal(size=N), 0), TS_S)
    loose = dataclasses.replace(study(), record=record)
    assert words.verdict(loose)[0].startswith("The displacement does not follow the voltage: a linear")
    assert (loose.follows_voltage, study().follows_voltage) == (False, True)
    assert "aligned" not in "".join(words.verdict(loose))


def test_terminal_shows_rows_notes_evidence_and_refusals() -> None:
    abilities = (Ability("drift", "above", 0.5, "um"), Ability("periodic", "named"))
    whole = study(
        HUM, CREEP, refused=(Refused("delay", "too short"),), abilities=abilities, remaining=left(0.1, STEP),
        next_experiment="rest longer",
    )  # fmt: skip
    blocks = words.diagnosis_text(whole).split("\n\n")
    assert blocks[0] == "a.csv: 360 rows to identify; scores are of the 240 held out"
    assert blocks[2].splitlines()[-4:] == [
        "noise floor from repeated periods; own: without what no model can know",
        "gain: fall of own, block bootstrap; of the error: share of its power above the noise",
        words.CONFIDENCE, "taken out of own: a step",
    ]  # fmt: skip
    assert blocks[3].splitlines() == [
        "periodic: evidence of periodic (f 50.000 ± 0.010 Hz, amplitude 2 um)",
        "creep: evidence of creep (per decade 0.02, from 0.02 s)",
        "not named: delay: too short", "could show drift: only an effect of at least 0.5 um",
    ]  # fmt: skip
    advised = blocks[4].splitlines()
    assert (advised[0], len(advised)) == ("what to do about periodic", 1 + 5 + 3)
    # sqrt(0.25 - 0.8 (0.25 - 0.0001)) um.
    assert (
        advised[-1]
        == "gain: cured alone, it takes the paper's model from 0.5 to 0.224 um; cured last, from 0.3 to 0.1 um"
    )
    assert blocks[5].splitlines()[0] == "what to do about creep"
    assert blocks[5].splitlines()[-1] == "gain: cured alone, it takes the paper's model from 0.5 to 0.461 um"
    assert blocks[6].splitlines()[0].split() == ["error", "rms", "by", "paper's", "model", "extended"]
    assert blocks[7].splitlines()[0] == "model: 2 rules"
    assert blocks[8] == "next experiment: rest longer"
    plain = words.diagnosis_text(study()).split("\n\n")
    assert words.CONFIDENCE not in plain[2]
    assert plain[3].splitlines()[0].split() == ["error", "rms", "by", "paper's", "model"]
    assert len(plain) == 5
    late = words.diagnosis_text(study(held_rows=np.arange(CUT + 40, N))).splitlines()[0]
    assert "360 rows to identify; scores are of 200 of the 240 held out: the first rows of a file" in late
    assert [row[0] for row in words.where_rows(whole)] == [one.quantity for one in whole.before.profiles]
    assert words.where_rows(whole)[0][1:] == ["0.1 um (25 V) .. 0.5 um (75 V)", "0.02 um (25 V) .. 0.1 um (75 V)"]
    assert words.where_rows(study())[0][1:] == ["0.1 um (25 V) .. 0.5 um (75 V)"]


def test_parameters_have_their_unit_and_two_digits_of_their_error() -> None:
    found = {
        "corner_um_per_s": (0.25, 0.1), "half_widths": (12.0, 1.0), "tiny_um": (3e-9, 2e-10), "at_V": (2.0, 0.0),
        "small_um": (3.1e-8, 2e-8), "odd": (1234.0, 99.0), "late_samples": (7.25, math.inf),
    }  # fmt: skip
    one = dataclasses.replace(HUM, parameters={key: Estimate(*pair) for key, pair in found.items()})
    assert words.parameter_text(study(one), "periodic").split(", ") == [
        "corner 0.25 ± 0.10 um/s", "half widths 12.0 ± 1.0", "tiny 3e-09 ± 2e-10 um", "at 2 V",
        "small 0.000000031 ± 0.000000020 um", "odd 1234 ± 99", "late 7.25 samples",
    ]  # fmt: skip


def test_price_is_none_where_no_c_can_be_generated(monkeypatch: pytest.MonkeyPatch) -> None:
    price = words.price_of(model())
    assert price is not None
    assert min(price.cycles, price.bytes) > 0

    def refused(*_: Any) -> None:
        raise BudgetError("too slow")

    monkeypatch.setattr(words, "cost_figures", refused)
    assert words.price_of(model()) is None


# In sections and key figures


def test_model_section_states_ranges_parts_and_certificates() -> None:
    rough = random_model(2, wild=3.0)
    section = model_section(model())
    assert cells(section)[:4] == [
        ["rules", "2 over 0 .. 10 um"], ["displacement range", "0 .. 10 um"], ["input range", "0 .. 100 V"],
        ["sampling period", "1000 µs"],
    ]  # fmt: skip
    assert section.text == ["made_up: first-order lag, time constant 0.00144 s; DC gain 0.1 um/V"]
    assert [row[2].split()[0] for row in cells(section, 1)] == ["gain", "slope", "inverse:"]
    assert "6 consequents of the rules, 0 weights" in section.notes[0]
    assert [row[1] for row in cells(section, 1)] == ["yes"] * 3
    assert "NO" in [row[1] for row in cells(model_section(rough), 1)]
    with_term = model_section(model_with([Periodic((50.0,))]))
    assert [row[0] for row in cells(with_term)[4:]] == ["disturbance: periodic"]
    assert ", 2 weights" in with_term.notes[0]


def test_equality_is_told_by_function_with_every_difference() -> None:
    assert cells(equivalence_section(EQUAL)) == [
        ["made_up", "predict", "1000", "3", "equal"], ["made_up", "inverse", "50", "4", "equal"],
        ["other", "predict", "5000", "3", "equal"],
    ]  # fmt: skip
    assert equivalence_section(EQUAL).text == ["Equal in every bit over 1050 samples per build."]
    assert equivalence_section(EQUAL).notes == ["builds: gcc -O2, clang.", "NOT COMPARED: tcc: none."]
    wrong = equivalence_section(WRONG)
    assert [row[4] for row in cells(wrong)] == ["equal", "1 differ", "equal"]
    assert wrong.text == ["NOT EQUAL: 1 runs differ."]
    assert wrong.notes[2:] == ["ALTERED: made_up.c.", f"DIFFERENT: {MISMATCH}."]
    assert list(wrong.tables[0].numbers) == [3, 4]
    assert equivalence_section(None, "no compiler").text == ["Not compared: no compiler."]


def test_cost_is_told_by_function_and_against_the_period() -> None:
    section = cost_section(COST)
    assert cells(section) == [["init", "~90", "2.4 %", "3", "7"], ["predict", "300", "8 %", "30", "70"]]
    assert section.text == ["One sample takes 300 cycles of 3750 at 100 kHz and 375 MHz: 8 %."]
    assert section.notes[0] == "Bytes: made_up_t 44, constants 128."
    assert section.notes[1].startswith("~ cycles are estimated")
    measured = cost_section(dataclasses.replace(COST, functions=COST.functions[1:]))
    assert len(measured.notes) == len(section.notes) - 1
    assert cost_section(None, "no C").text == ["Not known: no C."]


def test_uncertainty_section_has_the_budget_and_the_removed_errors() -> None:
    parts = (Contribution("sensor", 0.003, "B", "data sheet"), Contribution("noise", 0.004, "A", "record"))
    found: Any = type("Found", (), {
        "budget": Budget("displacement", parts), "removed": (("creep", 0.01234),), "missing": ("drift",),
    })  # fmt: skip
    section = uncertainty_section(found)
    expected = (
        "Expanded uncertainty 0.0098 um: k = 1.96 for a coverage of 95 %, combined standard uncertainty 0.005 um."
    )
    assert section.text == [expected]
    assert cells(section)[0] == ["sensor", "B", "0.003", "inf", "36.0 %", "data sheet"]
    assert list(section.tables[0].numbers) == [3, 4, 5]
    assert cells(section, 1) == [["creep", "0.0123"]]
    assert list(section.tables[1].numbers) == [2]
    assert section.notes[0] == "Not known: drift."
    found.removed = ()
    assert len(uncertainty_section(found).tables) == 1


def test_key_figures_are_those_of_the_diagnosis_and_of_its_c() -> None:
    shown = {figure.label: (figure.value, figure.note) for figure in key_figures(BOTH, WRONG, COST)}
    fit = 100.0 * (1.0 - 0.1 / float(np.std(Y_UM[CUT:])))
    assert shown == {
        f"free run, {BASE}": ("0.5 µm", "6.2 % of the stroke, held out"),
        "free run, extended": ("0.1 µm", "cold 0.1 µm; finer model 0.02 µm"),
        "fit (NRMSE)": (f"{fit:.4g} %", "free run of the model written, held out"),
        "noise floor": ("0.01 µm", "from repeated periods"),
        "price a sample": ("+33 cycles", "+36 bytes; 8 % of a sample in all"),
        "generated C": ("NOT EQUAL", "1050 samples per build"),
    }
    few = {figure.label: figure for figure in key_figures(study(), EQUAL, None)}
    assert list(few) == [f"free run, {BASE}", "free run, own", "fit (NRMSE)", "noise floor", "generated C"]
    assert few["generated C"].value == "equal bits"
    assert few["fit (NRMSE)"].value == f"{100.0 * (1.0 - 0.5 / float(np.std(Y_UM[CUT:]))):.4g} %"
    assert key_figures(study(HUM), None, None)[-1].note == "+24 bytes"
    terms = {word for word, _ in TERMS}
    assert all(
        figure.explained and figure.label.partition(",")[0] in terms for figure in key_figures(BOTH, EQUAL, COST)
    )
    assert file_names("a.csv[0:5], b.csv, a.csv[7:9]") == "a.csv, b.csv"


def test_sections_of_a_page_hold_the_causes_the_ladder_and_their_pictures() -> None:
    lost = cause("drift", CREEP.step, 0.0, extended=False)
    whole = study(
        dataclasses.replace(HUM, share=0.1), CREEP, lost, unknown="a jump", remaining=left(0.1, STEP),
        next_experiment="rest longer", refused=(Refused("delay", "too short"),),
        abilities=(Ability("periodic", "named"), Ability("slew", "above", 0.5, "V/s")),
    )  # fmt: skip
    page = diagnosis_page(whole, proof=(EQUAL, COST), command="hysgen diagnose a.csv")
    assert page.title == "a.csv: what the simulation gets wrong"
    by_title = {section.title: section for section in page.sections}
    causes = by_title["Causes and their evidence"]
    assert cells(causes) == [
        ["creep", "15.0 %", "0.987", "evidence of creep", "per decade 0.02, from 0.02 s"],
        ["periodic", "10.0 %", "0.987", "evidence of periodic", "f 50.000 ± 0.010 Hz, amplitude 2 um"],
        ["drift", "not extended", "0.987", "evidence of drift", ""],
        ["unknown", "4.0 %", "", "a jump", ""],
    ]
    assert f"{lost.why_not_extended}." in causes.notes
    assert causes.notes[-1] == f"C{words.CONFIDENCE[1:]}."
    tells = by_title["What this record can tell"]
    assert cells(tells) == [["periodic", "yes: named"], ["slew", "only an effect of at least 0.5 V/s"]]
    assert cells(tells, 1) == [["delay", "too short"]]
    assert tells.text == ["Next experiment: rest longer."]
    cards = by_title["What to do to the stage"].cards
    titles = [card.title for card in cards]
    assert titles == [
        "creep, 15.0 % of the error",
        "periodic, 10.0 % of the error",
        "unknown",
    ]
    assert [card.drawing[:5] for card in cards] == ["", "<svg ", ""], "the model has no creep"
    assert [head for head, _ in cards[0].lines] == ["means", "change", "gain"]
    ladder = next(section for title, section in by_title.items() if title.startswith("What each"))
    assert cells(ladder) == whole.ladder()
    assert ladder.notes[:2] == [whole.diagnosis.remaining.line(), "Taken out: a step."]
    assert ladder.notes[-1].startswith("Not explained: 4.0 % of the power")
    where = by_title["Where the error lies"]
    assert where.text[0].startswith("45 % of the power")
    assert ", 9 % of that of the extended model." in where.text[0]
    assert [one.name for one in where.pictures] == ["profiles", "time", "horizon", "spectrum"]
    assert [one.name for one in by_title["The record"].pictures] == ["record"]
    facts = dict(cells(by_title["Provenance"]))
    assert (facts["command"], facts["record"]) == ("hysgen diagnose a.csv", "a.csv")
    assert (facts["identified on"], facts["scored on"]) == ("rows 0 to 359", "rows 360 to 599")
    assert facts["sampling period"] == "1000 µs"
    numbers = {table.caption or head: list(table.numbers) for head, one in by_title.items() for table in one.tables}
    assert {name: columns for name, columns in numbers.items() if columns} == {
        ladder.title: [2, 3, 4, 5, 6, 7, 8, 9], "Cost against budget": [2, 3, 4, 5],
        "Generated C against its reference": [3, 4],
    }  # fmt: skip
    empty = {one.title: one for one in diagnosis_page(study(), proof=(EQUAL, COST)).sections}
    assert empty["Causes and their evidence"].text[0].startswith("None: the error of the paper's model is not above")
    assert not empty["Causes and their evidence"].tables
    assert "command" not in dict(cells(empty["Provenance"]))


def test_page_of_models_has_the_scores_of_all_and_the_rest_of_the_last() -> None:
    record = Record.from_arrays(U_V, Y_UM, TS_S, source="a.csv")
    other = dataclasses.replace(model(), name="other")
    scores = {"a": scored("a", 0.02, 0.4), "b": scored("b", 0.005, 0.3)}
    rivals = {"line": Score(0.9, 1.8, 5.0, 1.25, 600)}
    page = model_page("title", record, {"a": model(), "b": other}, scores, rivals, "command")
    assert list(page.lead) == ["Free run over 600 samples: a 0.4 um rms, b 0.3 um rms; the noise is 0.01 um."]
    assert [figure.label for figure in page.figures] == ["free run, a", "free run, b", "noise floor"]
    assert page.figures[0].value == "0.4 µm"
    assert page.figures[0].note.startswith("1.2 % of the stroke; fit (NRMSE) ")
    assert page.figures[2].value == "0.01 µm"
    assert page.figures[2].note == "from spectra of the slowest rows, if it is white"
    assert [row[:2] for row in cells(page.sections[0])] == [
        ["a, free run", "0.40000"], ["b, free run", "0.30000"],
        ["a, free run, own", "0.40000"], ["b, free run, own", "0.30000"],
        ["a, one step", "0.02000"], ["b, one step", "0.00500"],
        ["persistence, one step", "0.07000"], ["line, free run", "0.90000"],
    ]  # fmt: skip
    assert list(page.sections[0].tables[0].numbers) == [2, 3, 4, 5]
    notes = page.sections[0].notes
    assert notes[0] == "Noise floor 0.01 um rms from spectra of the slowest rows, if it is white."
    assert list(notes[1:3]) == ["Warning: a is odd.", "Warning: b is odd."]
    drawn = {picture.name: picture for picture in page.sections[1].pictures}
    free = lines_of(drawn["free-run"].figure)
    np.testing.assert_allclose(free["b"].get_ydata(), free_run(other, record)[0].y_um)
    np.testing.assert_allclose(free["b"].get_xdata(), T_S)
    assert (free["a"].get_color(), free["b"].get_color()) == (plots.SIMULATED, plots.EXTENDED)
    assert drawn["horizon"].alt == "Error rms from 1 to 10 samples ahead: a 0.02 to 0.4 µm; b 0.005 to 0.3 µm."
    provenance = dict(cells(page.sections[-1]))
    assert (provenance["command"], provenance["model"].split(",")[0]) == ("command", "other")
