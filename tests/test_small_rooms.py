"""Display, estimator and interface: every branch of a table, every argument that is handed on, every refusal."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import hysgen
from hysgen import estimator as estimating
from hysgen import schemas
from hysgen.api import code as coding
from hysgen.api import diagnosing, models
from hysgen.checking.bits import VerifySettings
from hysgen.display import Displayed, Summary, decimal, table
from hysgen.errors import FitError, HysgenError, RecordWarning
from hysgen.firmware.image import NO_KEY, Label, encode
from hysgen.fitting import FitSettings, PathSize
from hysgen.model.scores import score

TS_S = 1e-3
U_V = np.repeat(np.random.default_rng(2).uniform(0.0, 100.0, 60), 10) + np.tile(np.linspace(0, 9, 10), 60)
Y_UM = np.zeros(601)
for _k, _u in enumerate(U_V):
    Y_UM[_k + 1] = 0.6 * Y_UM[_k] + 0.04 * _u + 0.2 * np.sin(0.1 * _u)
RECORD = hysgen.Record.from_arrays(U_V, Y_UM[:-1], TS_S)


def test_a_table_aligns_names_to_the_left_and_numbers_to_the_right() -> None:
    rows = [["a", "b", "1"], ["longer", "bb", "1234567"]]
    assert table(["n", "kind", "value"], rows, left=2).splitlines() == [
        "n       kind    value",
        "------  ----  -------",
        "a       b           1",
        "longer  bb    1234567",
    ]
    assert table(["n", "kind", "v"], [["a", "b", "1"]]).splitlines()[2] == "a     b  1"
    with pytest.raises(ValueError, match="zip"):
        table(["n"], [["a", "b"]])


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (13824.0, 2, "14000"),
        (-13824.0, 2, "-14000"),
        (999_999_999.0, 3, "1000000000"),
        (1e9, 2, "1e+09"),
        (1e-6, 2, "0.0000010"),
        (1.234e-6, 3, "0.00000123"),
        (9.99e-7, 2, "1e-06"),
        (9.96e-5, 2, "0.0001"),
        (0.0, 3, "0"),
        (12.5, 4, "12.5"),
    ],
)
def test_a_decimal_has_no_exponent_between_a_millionth_and_a_milliard(value: float, digits: int, text: str) -> None:
    assert decimal(value, digits) == text


@dataclasses.dataclass(frozen=True, repr=False)
class Result(Displayed):
    content: Summary

    def summary(self) -> Summary:
        return self.content


def test_a_result_is_shown_whole_as_text_and_escaped_as_html(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Result(Summary("t <1>", ["h&", "v"], [["x<", "1"], ["y", "22"]], ["note >"], 1, ["first &"]))
    assert str(whole).splitlines() == ["t <1>", "first &", "h&   v", "--  --", "x<   1", "y   22", "note >"]
    assert whole._repr_html_().splitlines() == [
        "<p><strong>t &lt;1&gt;</strong></p>",
        "<p>first &amp;</p>",
        "<table><thead><tr><th>h&amp;</th><th>v</th></tr></thead><tbody>",
        "<tr><td>x&lt;</td><td>1</td></tr>",
        "<tr><td>y</td><td>22</td></tr>",
        "</tbody></table>",
        "<p>note &gt;</p>",
    ]
    assert repr(whole) == "<t <1>>"
    bare = Result(Summary("t", ["h"], ()))
    assert (str(bare), bare._repr_html_()) == ("t", "<p><strong>t</strong></p>")
    shown: list[str] = []
    for cycle in (False, True):
        whole._repr_pretty_(SimpleNamespace(text=shown.append), cycle)
    assert shown == [str(whole), repr(whole)]
    drawn: list[Any] = []
    monkeypatch.setitem(
        sys.modules, "hysgen.report.plots.results", SimpleNamespace(draw=lambda *what: drawn.append(what))
    )
    whole.plot("a", 3)
    assert drawn == [(whole, "a", 3)]

    def wrong(*what: Any) -> None:
        raise TypeError("takes 1 argument")

    monkeypatch.setitem(sys.modules, "hysgen.report.plots.results", SimpleNamespace(draw=wrong))
    with pytest.raises(HysgenError, match=r"^Result: nothing to plot for 'a', 3; call plot\(\) without it$"):
        whole.plot("a", 3)
    with pytest.raises(TypeError, match="takes 1 argument"):
        whole.plot()


def test_the_estimator_fits_predicts_and_scores_by_its_parameters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(estimating, "unknown_past", lambda *given: SimpleNamespace(rows=(13, 99)))
    estimator = hysgen.HysteresisRegressor(Ts_s=TS_S, rules=3, memory=False, method="batch")
    assert repr(estimator) == "HysteresisRegressor(Ts_s=0.001, rules=3, memory=False, method='batch')"
    assert estimator.get_params() == {"Ts_s": TS_S, "rules": 3, "memory": False, "method": "batch"}
    assert estimator.get_params(deep=False) == estimator.get_params()
    for parameters, memory in (({}, None), ({"memory": True}, PathSize())):
        X, y = U_V[:, None], Y_UM[:-1]
        assert estimator.set_params(**parameters).fit(X, y) is estimator
        assert estimator.model_ == models.fit_model(RECORD, FitSettings(rules=3, memory=memory, method="batch"))
        assert estimator.__sklearn_is_fitted__()
        np.testing.assert_array_equal(estimator.predict(X), estimator.model_.simulate(U_V))
        left = y[13:]
        free = estimator.model_.simulate(U_V, float(y[0]))[13:]
        expected = 1.0 - np.sum((left - free) ** 2) / np.sum((left - left.mean()) ** 2)
        assert estimator.score(X, y) == pytest.approx(expected, rel=1e-12)
        assert estimator.score(X, 2.0 * y + 1.0) < 0.9
    defaults = hysgen.HysteresisRegressor()
    assert defaults.get_params() == {"Ts_s": None, "rules": 6, "memory": True, "method": "refined"}
    assert defaults._estimator_type == "regressor"
    with pytest.raises(FitError, match=r"^colour: is no parameter; choose from Ts_s, rules, memory, method$"):
        defaults.set_params(colour=1)
    with pytest.raises(FitError, match=r"^the estimator is not fitted;"):
        defaults.score(U_V, Y_UM[:-1])


def test_tags_of_the_estimator_are_those_of_a_regressor(monkeypatch: pytest.MonkeyPatch) -> None:
    def kind(name: str) -> Any:
        return lambda **given: (name, given)

    kinds = {name: kind(name) for name in ("Tags", "TargetTags", "RegressorTags", "InputTags")}
    monkeypatch.setitem(sys.modules, "sklearn.utils", SimpleNamespace(**kinds))
    assert hysgen.HysteresisRegressor().__sklearn_tags__() == (
        "Tags",
        {
            "estimator_type": "regressor",
            "target_tags": ("TargetTags", {"required": True}),
            "regressor_tags": ("RegressorTags", {}),
            "input_tags": ("InputTags", {}),
        },
    )


def test_fit_hands_on_settings_memory_and_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(models, "fit_model", lambda *given, **options: asked.append((given, options)))
    monkeypatch.setattr(models, "check_for_fit", lambda *given: asked.append(given) or ("poor",))
    base = FitSettings(rules=4, method="batch")
    for memory, size in (
        (True, PathSize()),
        (5, PathSize(plays=5)),
        (1, PathSize(plays=1)),
        (PathSize(plays=2), PathSize(plays=2)),
    ):
        asked.clear()
        with pytest.warns(RecordWarning, match="^poor$") as seen:
            hysgen.fit(RECORD, base, memory=memory, progress=print, rules=3)
        assert seen[0].filename == __file__
        settings = FitSettings(rules=3, method="batch", memory=size)
        weights = size.operator(*RECORD.u_range_V).size
        assert asked == [(RECORD, 3, 9 + weights), ((RECORD, settings), {"progress": print})]
    asked.clear()
    with pytest.warns(RecordWarning):
        hysgen.fit(RECORD)
    assert asked == [(RECORD, 6, 18), ((RECORD, FitSettings()), {"progress": None})]
    with pytest.raises(FitError, match=r"^rulez: is not known"):
        hysgen.fit(RECORD, rulez=3)


def test_diagnose_checks_both_records_and_prices_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(diagnosing, "diagnose_and_evaluate", lambda *given: asked.append(given))
    monkeypatch.setattr(diagnosing, "check_for_fit", lambda *given: asked.append(given) or ())
    monkeypatch.setattr(diagnosing, "check_validation", lambda *given: asked.append(given) or ("outside",))
    held = RECORD.rows(0, 300)
    with pytest.warns(RecordWarning, match="^outside$"):
        hysgen.diagnose(RECORD, held, progress=print, keep_all=True)
    settings = dataclasses.replace(hysgen.DiagnoseSettings(), keep_all=True, price=diagnosing.price_of)
    assert asked == [(RECORD, 6, 18), (RECORD, held), (RECORD, held, settings, print)]
    asked.clear()
    free = hysgen.DiagnoseSettings(price=lambda model: None)
    hysgen.diagnose(RECORD, settings=free)
    (part, *size), evaluated = asked
    assert (part.samples, *size) == (RECORD.split(free.identify)[0].samples, 6, 18), "the part that is identified on"
    assert evaluated == (RECORD, None, free, None)


def test_verify_compares_texts_or_a_folder_with_what_was_altered(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    folder = SimpleNamespace(model="m", texts={"a": "b"}, altered=("a",))
    monkeypatch.setattr(coding, "verify_texts", lambda *given: asked.append(given))
    monkeypatch.setattr(coding, "read_folder", lambda path: asked.append(path) or folder)
    model = hysgen.load_model("appendix_a")
    hysgen.verify(hysgen.Generated(model, {"x": "y"}), 500, print)
    hysgen.verify("somewhere")
    assert asked == [
        (model, {"x": "y"}, VerifySettings(samples=500, other_models=0), print),
        Path("somewhere"),
        ("m", {"a": "b"}, VerifySettings(samples=200_000, other_models=0), None, ("a",)),
    ]
    monkeypatch.setattr(coding, "cost_of_texts", lambda *given, **options: (given, options))
    assert hysgen.cost("there") == (("m", {"a": "b"}), {"timed": False})
    checks = {"one": lambda *given: given, "two": lambda *given: given}
    monkeypatch.setattr(coding, "CHECKS", checks)
    monkeypatch.setattr(coding, "known_checks", lambda names: list(names))
    proof = hysgen.prove(hysgen.Generated(model, {"x": "y"}), ["two", "one"], progress=print)
    assert proof.model == "appendix_a"
    assert proof.checks == {name: (model, {"x": "y"}, coding.CheckSettings(), print) for name in ("two", "one")}


def test_generated_files_are_listed_with_lines_and_bytes_and_written(tmp_path: Path) -> None:
    code = hysgen.Generated(hysgen.load_model("appendix_a"), {"a.h": "1\nµ\n", "b.c": "x"})
    found = code.summary()
    assert found.title == "C of model appendix_a: 2 files"
    assert (found.header, found.rows) == (["file", "lines", "bytes"], [["a.h", "2", "5"], ["b.c", "1", "1"]])
    assert code.write(str(tmp_path / "c")) == tmp_path / "c"
    assert (tmp_path / "c" / "a.h").read_text(encoding="utf-8") == code["a.h"]


def test_a_page_of_several_models_scores_each_on_the_record(monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = hysgen.load_model("appendix_a"), hysgen.load_model("appendix_b")
    monkeypatch.setattr("hysgen.report.model.ScoredModels", lambda *given: given)
    monkeypatch.setattr("hysgen.report.model.model_page", lambda *given: given)
    monkeypatch.setattr(diagnosing, "score", lambda model, record: (model.name, record))
    record = dataclasses.replace(RECORD, source="s.csv")
    scored = {"x": ("appendix_a", record), "y": ("appendix_b", record)}
    assert hysgen.page(({"x": a, "y": b}, record)) == ("x, y on s.csv", (record, {"x": a, "y": b}, scored))
    one = hysgen.page((a, "scores", record), "title")  # type: ignore[arg-type]
    assert one == ("title", (record, {"appendix_a": a}, {"appendix_a": "scores"}))


def test_short_functions_hand_on_their_arguments(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    model = hysgen.load_model("appendix_a")
    opened: list[Any] = []
    monkeypatch.setattr(coding, "open_line", lambda *given: opened.append(given) or "line")
    monkeypatch.setattr(coding, "Client", lambda line: ("client", line))
    assert hysgen.connect("/dev/x", 9600) == ("client", "line")
    hysgen.connect("/dev/x")
    assert opened == [("/dev/x", 9600), ("/dev/x", coding.BAUD)]
    learning = hysgen.firmware_files(model).model
    assert learning.learner is not None
    assert hysgen.firmware_files(learning).model is learning
    assert hysgen.image(learning) == encode(learning, Label(), NO_KEY)
    other = Label(device=3, build=2, counter=9)
    key = bytes(range(16))
    assert hysgen.image(learning, other, key) == encode(learning, other, key)
    assert hysgen.image(learning, other, key) != hysgen.image(learning, other)
    monkeypatch.setattr(models, "history_of", lambda *given: given)
    assert hysgen.history(str(tmp_path)) == (tmp_path, 5.0)
    assert hysgen.history(tmp_path, 2.0) == (tmp_path, 2.0)
    assert json.loads(schemas.text_of("score")) == hysgen.schema("score")
    options = coding.Options(inverse=False)
    monkeypatch.setattr(coding, "generate_texts", lambda *given: given)
    assert hysgen.generate(model, options).texts == (coding.Derived(model), options)
    assert hysgen.generate(model).texts == (coding.Derived(model), coding.Options(inverse=True))
    fitted = hysgen.fit(RECORD, method="batch", rules=3)
    assert hysgen.score(fitted, RECORD, 50).to_json() == score(fitted, RECORD, 50).to_json()
    refitted: list[Any] = []
    monkeypatch.setattr(models, "refit_model", lambda *given: refitted.append(given))
    hysgen.refit(fitted, RECORD, print)
    assert refitted == [(fitted, RECORD, print)]
