"""Display, estimator and interface: every branch of a table, every argument that is handed on, every refusal."""

import contextlib
import dataclasses
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import hysgen
from hysgen import estimator as estimating
from hysgen import targets
from hysgen.api import models
from hysgen.api.code import with_kernels
from hysgen.display import Displayed, Summary, decimal, table
from hysgen.errors import FitError, HysgenError
from hysgen.fitting import FitSettings, PathSize

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


def test_a_target_whose_package_is_missing_is_left_out_and_a_fault_inside_it_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for lacks, heard in (("hysgen_other", False), ("numpy.missing", True)):

        def load(lacks: str = lacks) -> Any:
            raise ModuleNotFoundError(f"No module named {lacks}", name=lacks)

        entries = [SimpleNamespace(name="other", module="hysgen_other.target", load=load)]
        monkeypatch.setattr(targets.metadata, "entry_points", lambda group, entries=entries: entries)
        with pytest.raises(ModuleNotFoundError, match=lacks) if heard else contextlib.nullcontext():
            assert list(targets.targets.__wrapped__()) == ["cortex-m4", "cortex-m7", "emulated"]


def test_generated_files_are_listed_with_lines_and_bytes_and_written(tmp_path: Path) -> None:
    code = hysgen.Generated(hysgen.load_model("appendix_a"), {"a.h": "1\nµ\n", "b.c": "x"})
    found = code.summary()
    assert found.title == "C of model appendix_a: 2 files"
    assert (found.header, found.rows) == (["file", "lines", "bytes"], [["a.h", "2", "5"], ["b.c", "1", "1"]])
    assert code.write(str(tmp_path / "c")) == tmp_path / "c"
    assert (tmp_path / "c" / "a.h").read_text(encoding="utf-8") == code["a.h"]
    with pytest.raises(HysgenError, match="cortex-m4: has no kernels"):
        with_kernels(code, targets.target("cortex-m4", "weights"))
