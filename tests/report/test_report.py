"""The report of a diagnosis: all sections, the numbers of the diagnosis, self-contained, equal bytes, alt texts."""

import base64
import dataclasses
import json
import math
import pickle
import re
import subprocess
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.bank_records import hum_study
from fixtures.tools import need
from hysgen.cli import main
from hysgen.diagnosis.evaluation import LADDER, Study
from hysgen.display import table
from hysgen.fitting import FitSettings, fit
from hysgen.model.file import load_model
from hysgen.model.scores import score
from hysgen.record import Record
from hysgen.report.page import readable, sentence, uncertainty_section
from hysgen.report.pages import model_page
from hysgen.report.plots import data_uri, png_bytes
from hysgen.report.plots.results import held_out_runs, pictures
from hysgen.report.plots.traces import time_picture
from hysgen.report.words import diagnosis_text, verdict
from hysgen.uncertainty.gum import sensor_uncertainty
from hysgen.uncertainty.simulated import characterise
from hysgen_lab.stage import Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.stage.signals import nested_amplitudes

pytestmark = pytest.mark.slow
"""Every page needs a diagnosis, or generated C that was verified."""

SECTIONS = (
    "What to do to the stage",
    "Causes and their evidence",
    "What each extension gains, and its price",
    "Where the error lies",
    "Measured and simulated",
    "The record",
    "What this record can tell",
    "Model and certificates",
    "Generated C against its reference",
    "Cost against budget",
    "Glossary",
    "Provenance",
)
PICTURES = 10
VOID = {"meta", "img", "br", "hr", "link", "input"}


@pytest.fixture(scope="module")
def hum(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> Study:
    study = once_per_run("hum", hum_study)
    assert isinstance(study, Study)
    return study


@pytest.fixture(scope="module")
def written(
    hum: Study, once_per_run: Callable[[str, Callable[[], Any]], Any], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, bytes]:
    """The files that the verb writes of this study, by their names in the folder."""

    def made() -> dict[str, bytes]:
        folder = tmp_path_factory.mktemp("hum")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("hysgen.api.diagnosing.diagnose_and_evaluate", lambda *_, **__: hum)
            patch.setattr("hysgen.cli.verbs.diagnose.read_records", lambda *_, **__: hum.record)
            patch.chdir(folder)
            call = ["diagnose", "hum.csv", "--report", "r.html", "--plots", "p", "--json", "d.json", "-o", "m.json"]
            assert main(call) == 0
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    files = once_per_run("hum_files", made)
    assert isinstance(files, dict)
    return files


@pytest.fixture(scope="module")
def page(written: dict[str, bytes]) -> str:
    return written["r.html"].decode("utf-8")


def small_record() -> Record:
    """40 ms of nested loops, at 10 kHz."""
    u_V = nested_amplitudes(1e-4, (50.0,), 40.0, 25.0, 2)
    return Record.from_arrays(u_V, measure(Stage.nominal(), u_V, 1e-4, 3).displacement_um, 1e-4, source="small.csv")


class Reader(HTMLParser):
    """Opening and closing tags in order, attributes, and the text of headings and cells."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(f"</{tag}> closes nothing that is open")

    def handle_data(self, data: str) -> None:
        if self.open[-1:] != ["style"]:
            self.text += data + " "


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    reader.close()
    return reader


@pytest.mark.slow
def test_every_section_of_the_report_is_there_and_holds_something(page: str) -> None:
    for title in SECTIONS:
        body = page.partition(f"<h2>{title}</h2>")[2].partition("</section>")[0]
        assert len(read(body).text.split()) > 10, title


def test_page_is_well_formed_and_every_link_leads_somewhere(page: str) -> None:
    reader = read(page)
    assert not reader.wrong
    assert not reader.open
    anchors = {attributes["id"] for _, attributes in reader.tags if "id" in attributes}
    links = [attributes["href"] for tag, attributes in reader.tags if tag == "a"]
    inner = [link for link in links if link is not None and link.startswith("#")]
    # The contents, the labels of the figures at the top that the glossary explains; each picture, large and back.
    assert len(inner) == len(SECTIONS) + 6 + 2 * PICTURES
    assert all(link.removeprefix("#") in anchors for link in inner)
    tables = [link for link in links if link is not None and link.startswith("data:text/csv;base64,")]
    assert len(tables) == sum(tag == "table" for tag, _ in reader.tags)
    assert base64.b64decode(tables[0].partition(",")[2]).decode().startswith("cause,of the error,")


def test_page_needs_no_other_file_and_no_script(page: str) -> None:
    reader = read(page)
    sources = [value for _, a in reader.tags for key, value in a.items() if key in ("src", "href") and value]
    assert all(source.startswith(("#", "data:image/svg+xml,", "data:text/csv;base64,")) for source in sources)
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in reader.tags}
    without_pictures = re.sub(r'"data:[^"]*"', "", page)
    assert "http" not in without_pictures
    assert "url(" not in without_pictures


def test_every_picture_says_in_words_what_it_shows(page: str) -> None:
    words = [attributes.get("alt") or "" for tag, attributes in read(page).tags if tag == "img"]
    assert len(words) == PICTURES
    assert len(set(words)) == len(words)
    assert all(re.search(r"\d", alt) for alt in words)


@pytest.mark.parametrize("width", [390, 1280])
def test_browser_shows_the_page_without_scrolling_sideways(page: str, width: int, tmp_path: Path) -> None:
    """The page in a frame as wide as a phone or a desktop screen."""
    need("chromium")
    tell = "<script>onload=()=>parent.postMessage([document.documentElement.scrollWidth,innerWidth,loaded()],'*');"
    tell += "function loaded(){return [...document.images].filter(i=>i.naturalWidth>0).length}</script>"
    (tmp_path / "page.html").write_text(page.replace("</body>", tell + "</body>"))
    (tmp_path / "frame.html").write_text(
        f"<body><iframe src='page.html' style='width:{width}px;height:900px;border:0'></iframe>"
        "<script>onmessage=e=>document.body.innerHTML='<p>told '+e.data.join(' ')+' end</p>'</script></body>"
    )
    options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}"]
    call = ["chromium", *options, "--virtual-time-budget=20000", "--dump-dom", (tmp_path / "frame.html").as_uri()]
    dom = subprocess.run(call, capture_output=True, text=True, check=False, timeout=120).stdout
    told = re.search(r"told (\d+) (\d+) (\d+) end", dom)
    assert told is not None, dom[-300:]
    wide, shown, images = map(int, told.groups())
    assert (wide <= shown, shown, images) == (True, width, PICTURES)


def test_page_shows_the_numbers_of_the_diagnosis(hum: Study, page: str) -> None:
    text, found = read(page).text, hum.diagnosis
    assert found.names == ("memory", "periodic")
    for number in (found.base_rms_um, found.extended_rms_um, *(cause.step.after_um for cause in found.causes)):
        assert f"{number:.4g}" in text
    assert all(readable(cause.evidence) in text for cause in found.causes)
    assert "Equal in every bit" in text
    assert hum.record.digest in text


def test_error_shown_is_the_error_that_was_scored(hum: Study) -> None:
    # The held-out rows are contiguous here, so error profiles and ladder use the same samples.
    assert hum.before.rms_um == pytest.approx(hum.diagnosis.base_rms_um, rel=1e-12)
    assert hum.after.rms_um == pytest.approx(hum.diagnosis.extended_rms_um, rel=1e-12)
    held = hum.held_out()
    assert float(((held.base_um - held.measured_um) ** 2).mean() ** 0.5) == pytest.approx(hum.before.rms_um, rel=1e-12)


def test_terminal_notebook_and_page_show_one_table_of_the_ladder(hum: Study, page: str) -> None:
    lines = table(LADDER, hum.ladder())
    assert lines in diagnosis_text(hum)
    assert lines in str(hum)
    shown = read(page).text
    for row in hum.ladder():
        assert re.search(r"\s+".join(re.escape(readable(cell)) for cell in row if cell), shown), row


def test_uncertainty_of_a_diagnosis_is_a_section_of_its_report(hum: Study) -> None:
    found = characterise(hum, sensor_uncertainty("5nm,k=2"))
    section = uncertainty_section(found)
    words = {"contribution", "type", "from"}
    assert {section.tables[0].header[place - 1] for place in section.tables[0].numbers}.isdisjoint(words)
    causes = [f"model error, {cause.name}" for cause in hum.diagnosis.causes]
    assert [row[0] for row in section.tables[0].cells] == ["sensor", "noise", *causes, "model error, rest"]
    assert found.budget.combined_um == pytest.approx(
        math.hypot(*(part.contribution_um for part in found.budget.contributions))
    )
    assert any(note.startswith("Not known: drift") for note in section.notes)
    assert {name for name, _ in found.removed} == {cause.name for cause in hum.extended}


def test_verb_writes_page_pictures_and_json_and_the_same_study_gives_the_same_bytes(
    hum: Study, page: str, written: dict[str, bytes], tmp_path: Path
) -> None:
    told = json.loads(written["d.json"])
    assert [cause["name"] for cause in told["causes"]] == ["memory", "periodic"]
    assert told["causes"][0]["cost"]["cycles"] > 0
    assert told["error_of_base"]["rms_um"] == told["free_run_rms"]["base"]
    assert sum(name.startswith("p/") for name in written) == PICTURES
    for picture in pictures(hum)[:2]:
        assert written[f"p/{picture.name}.png"] == png_bytes(picture.figure)
        assert data_uri(picture.figure) in page
    # Helper processes draw pictures too; the last one is as in the page.
    sent = [pickle.loads(pickle.dumps(picture.figure)) for picture in pictures(hum)]
    assert data_uri(sent[-1]) in page
    (tmp_path / "m.json").write_bytes(written["m.json"])
    assert load_model(str(tmp_path / "m.json")).terms == hum.diagnosis.model.terms


def test_models_have_a_page_of_the_same_kind() -> None:
    record = small_record()
    models = {name: fit(record, FitSettings(rules=rules, method="batch")) for name, rules in (("two", 2), ("four", 4))}
    scores = {name: score(model, record) for name, model in models.items()}
    reader = read(model_page("t <&>", record, models, scores).html())
    assert not reader.wrong
    assert not reader.open
    assert "Certificates over the whole range" in reader.text
    assert "t <&>" in reader.text
    assert all(f"{s.free_run.e_rms_um:.5f}" in reader.text for s in scores.values())


def test_each_error_in_time_fills_an_axis_of_its_own(hum: Study) -> None:
    assert hum.improved
    for axis in time_picture(held_out_runs(hum)).figure.axes:
        (line,) = axis.lines
        low, high = axis.get_ylim()
        assert np.ptp(line.get_ydata()) > 0.5 * (high - low)
    assert len(time_picture(held_out_runs(hum)).figure.axes) == 2


def test_logs_that_are_not_aligned_are_said_before_the_causes(hum: Study) -> None:
    record = hum.record
    (segment,) = record.segments
    without = [abs(np.corrcoef(segment.u_V, np.roll(segment.y_um, shift))[0, 1]) for shift in range(1000)]
    apart = dataclasses.replace(segment, y_um=np.roll(segment.y_um, int(np.argmin(without))))
    shifted = dataclasses.replace(record, segments=(apart,))
    first, *_ = verdict(dataclasses.replace(hum, record=shifted))
    assert "the logs are not aligned, and what follows describes their shift." in first
    assert "aligned" not in "".join(verdict(hum))


def test_sentences_of_a_page_begin_with_a_capital_and_names_do_not() -> None:
    told = [sentence(text) for text in ("resonance is named", "record.csv: 50 samples", "stage: a lag", "")]
    assert told == ["Resonance is named", "record.csv: 50 samples", "stage: a lag", ""]
