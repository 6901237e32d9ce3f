"""Two quantities with free names and units go through words, pages, plots, C, A2L and FMU; V and um are nowhere."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

import hysgen
from hysgen.cli import main
from hysgen.display import Quantities, written_in
from hysgen.errors import HysgenError
from hysgen.export import export_texts
from hysgen.model.learner_settings import LearnerSettings
from hysgen.record.columns import Columns
from hysgen.report.plots import Text

K = np.arange(1500)
B_MT = np.round(60.0 - 60.0 * np.cos(0.02 * K) * np.abs(np.cos(0.0031 * K)), 4)
PHI_DEG = np.round(0.004 * np.convolve(B_MT, 0.7 ** np.arange(30), "full")[: K.size] + 1e-4 * np.sin(2.0 * K**2), 6)
OTHER = Quantities("field", "mT", "angle", "deg")
STATED = "voltage=B_mT,displacement=phi_deg,input=field [mT],output=angle [deg]"
OWN_UNITS = re.compile(
    r"(?<![\w./'-])(?:um|\N{MICRO SIGN}m|V)(?![\w=-]|\.\w)|\b[Vv]oltage\b(?!=)|\b[Dd]isplacement\b(?!=)"
)
COMMENTS = re.compile(r'/\*.*?\*/|"[^"\n]*"', re.DOTALL)


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    rows = (f"{1e-3 * k:.3f},{b},{phi}\n" for k, b, phi in zip(K, B_MT, PHI_DEG, strict=True))
    Path("log.csv").write_text("time_s,B_mT,phi_deg\n" + "".join(rows))
    return "log.csv"


@pytest.mark.slow
def test_all_that_is_printed_and_written_is_in_the_stated_quantities(
    log: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for words in (
        ["inspect", log, "--columns", STATED, "--json", "inspect.txt"],
        ["fit", log, "--columns", STATED, "-o", "stage.json", "--json", "fit.txt"],
        ["score", "stage.json", log, "--columns", "voltage=B_mT,displacement=phi_deg", "--report", "score.html"],
        ["describe", "stage.json", "--json", "describe.txt"],
        ["waveform", "stage.json", "sine", "-o", "wave.csv"],
        ["generate", "stage.json", "-o", "c"],
        ["experiment", log, "--columns", STATED, "-o", "next.csv"],
    ):
        assert main([*words]) == 0, words
    page = re.sub(r'"data:[^"]*"', "", Path("score.html").read_text())
    texts = [*capsys.readouterr(), page, Path("stage.json").read_text()]
    texts += [re.sub(r'"\w+":', "", Path(f"{verb}.txt").read_text()) for verb in ("inspect", "fit", "describe")]
    for text in texts:
        assert OWN_UNITS.findall(re.sub(r'"units": {.*?}', "", text)) == []
    assert '"_um": "deg"' in Path("describe.txt").read_text()
    assert Path("wave.csv").read_text().startswith("time_s,field_mT\n")
    assert Path("next.csv").read_text().startswith("time_s,field_mT\n")
    assert hysgen.load_model("stage.json").quantities == OTHER


def test_names_and_units_change_no_number(log: str) -> None:
    angle = hysgen.load_record(log, STATED)
    assert list(angle.to_dataframe().columns) == ["time_s", *angle.quantities.columns]
    length = hysgen.load_record(log, "voltage=B_mT,voltage_unit=V,displacement=phi_deg,displacement_unit=um")
    ours, theirs = hysgen.fit(angle), hysgen.fit(length)
    assert dataclasses.replace(ours, quantities=theirs.quantities) == theirs
    lines = [str(hysgen.score(ours, angle)), OTHER.text(str(hysgen.score(theirs, length)))]
    assert len({re.sub(r"[\s-]+", " ", text) for text in lines}) == 1
    assert "angle [deg]" in (labels := [text.get_text() for text in angle.plot().figure.findobj(Text)])
    assert not any(map(OWN_UNITS.search, labels))
    for target in ("fmu", "a2l", "shared"):
        made, plain = export_texts(ours, target), export_texts(theirs, target)
        for path in [path for path in made if path.endswith((".c", ".h")) and "fmi" not in path]:
            assert COMMENTS.sub("", made[path]).strip() == COMMENTS.sub("", plain[path]).strip(), path
            assert not any(map(OWN_UNITS.search, COMMENTS.findall(made[path]))), path
    assert 'unit="deg"' in (description := export_texts(ours, "fmu")["modelDescription2.xml"])
    assert OWN_UNITS.findall(description) == []


def test_quantities_that_do_not_fit_are_refused(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    angle = hysgen.load_record(log, STATED)
    model = hysgen.fit(angle)
    with pytest.raises(HysgenError, match="holds 'voltage' in 'V' and 'displacement' in 'um', not 'field' in 'mT'"):
        hysgen.score(model, hysgen.Record.from_arrays(B_MT, PHI_DEG, 1e-3))
    with pytest.raises(HysgenError, match="board layer"):
        hysgen.firmware_files(dataclasses.replace(model, learner=LearnerSettings()))
    for stated, fault in (
        ("input=field [mT]", "given together"),
        ("input=mT,output=angle [deg]", "'mT' is not a name and a unit"),
        ("input=field [mT],output=field [deg]", "call one of them otherwise"),
        (f"{STATED},displacement_unit=rad", "displacement_unit: 'rad' is not known; choose from deg"),
    ):
        with pytest.raises(HysgenError, match=re.escape(fault)):
            Columns.from_text(stated)
    assert main(["fit", log, "--columns", "voltage=B_mT,displacement=phi_deg", "-o", "m.json"]) == 2
    assert "input=field [mT],output=angle [deg]" in capsys.readouterr().err


def test_a_column_that_is_named_is_read_whatever_its_name(tmp_path: Path) -> None:
    rows = np.column_stack([1e-3 * np.arange(len(B_MT)), B_MT, B_MT[::-1], PHI_DEG])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="time_s,voltage_V,field_mT,angle_deg", comments="")
    both = "input=field [mT],output=angle [deg]"
    assert np.array_equal(hysgen.load_record(tmp_path / "log.csv", both).u_V, rows[:, 2])
    named = f"voltage=voltage_V,voltage_unit=mT,{both}"
    assert np.array_equal(hysgen.load_record(tmp_path / "log.csv", named).u_V, rows[:, 1])


def test_a_text_is_translated_once_and_tables_stay_straight() -> None:
    swapped = Quantities("displacement", "um", "voltage", "V")
    assert swapped.text("a voltage of 2 V moves by 3 um") == "a displacement of 2 um moves by 3 V"
    fmu = export_texts(dataclasses.replace(hysgen.load_model("appendix_a"), quantities=swapped), "fmu")
    assert re.findall(r'name="([yu]_\w+)".*unit="(\w+)"', fmu["modelDescription3.xml"])[:2] == [
        ("y_um", "V"),
        ("u_V", "um"),
    ]
    assert all(fmu[f"sources{standard}/appendix_a.c"] == fmu["model/appendix_a.c"] for standard in (2, 3))
    with written_in(OTHER):
        text = OTHER.text(hysgen.display.table(["model", "rms um", "n"], [["base", "0.4 um", "1"]]))
    assert text == "model  rms deg  n\n-----  -------  -\nbase   0.4 deg  1"
