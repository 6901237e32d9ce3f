"""link and demo: what each hands on, in which order, what it says, and its exit code."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hysgen.cli import main
from hysgen.cli.console import Console
from hysgen.cli.verbs import demo
from hysgen.cli.verbs import firmware as verbs
from hysgen.firmware.wire import LinkStatus, Request
from hysgen.model.file import load_model
from hysgen.record.read import IDENTIFICATION_ROWS, bundled_csv

WORDS = (13, 1, 640, 8, 3, 1, 500, 4, 1200, 1300, 0, 96)
STATUS = LinkStatus(6, 0x1001, 0x40000, 77, 2.0 / 3.0, 39.5, 2.0, 0.0, *WORDS, 39.5)


class Firmware:
    """What stands at the other end of the line."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []

    def __call__(self, *given: Any) -> Any:
        self.calls.append(given)
        return self

    def __enter__(self) -> Firmware:
        return self

    def __exit__(self, *_: object) -> None:
        self.calls.append(("closed",))

    def status(self) -> LinkStatus:
        return STATUS

    def identity(self) -> Any:
        return SimpleNamespace(name="stage", device=7)

    def request(self, request: Request) -> None:
        self.calls.append(("request", request))

    def reference(self, reference_um: float | None) -> None:
        self.calls.append(("reference", reference_um))

    def install(self, data: bytes, progress: Any) -> None:
        progress(0.5)
        self.calls.append(("install", data))

    def install_model(self, model: Any, key: bytes, progress: Any) -> None:
        progress(1.0)
        self.calls.append(("install_model", model.name, key))


def test_a_status_without_bits_is_zero() -> None:
    assert re.search(r"^status +0$", verbs.status_table(replace(STATUS, status=0)), re.M)


@pytest.fixture
def firmware(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Firmware:
    found = Firmware()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(verbs, "open_line", lambda *given: ("line", *given))
    monkeypatch.setattr(verbs, "Client", found)
    Path("image").write_bytes(b"HYSI")
    Path("key").write_text("00112233445566778899aabbccddeeff\n")
    return found


@pytest.mark.parametrize(
    ("words", "call"),
    [
        ("", None),
        ("status", None),
        ("start", ("request", Request.START)),
        ("stop", ("request", Request.STOP)),
        ("clear", ("request", Request.CLEAR)),
        ("reference 2.5", ("reference", 2.5)),
        ("reference", ("reference", None)),
        ("image image", ("install", b"HYSI")),
        (
            "install appendix_a --key key",
            ("install_model", "appendix_a", bytes.fromhex("00112233445566778899aabbccddeeff")),
        ),
    ],
    ids=str,
)
def test_link_does_one_thing_and_then_says_the_status(
    words: str, call: Any, firmware: Firmware, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["-q", "link", "port", *words.split(), "--json", "j"]) == 0
    assert firmware.calls == [(("line", "port", 115_200),), *([call] if call else []), ("closed",)]
    shown = dict(line.split(None, 1) for line in capsys.readouterr().out.splitlines()[2:])
    assert (shown["state"], shown["reading_um"], shown["output_V"]) == ("TRACK", "0.666667", "39.5")
    assert shown["status"] == "SENSOR_INVALID|IMAGE_REFUSED"
    assert (shown["counter"], shown["cycles_most"]) == ("8", "1300")
    told = json.loads(Path("j").read_text())
    assert {name: told[name] for name in vars(STATUS)} == vars(STATUS)


def test_link_says_the_identity_at_another_rate(firmware: Firmware, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["link", "port", "identify", "--baud", "9600", "--json", "j"]) == 0
    assert firmware.calls == [(("line", "port", 9600),), ("closed",)]
    assert [line.split() for line in capsys.readouterr().out.splitlines()[2:]] == [["name", "stage"], ["device", "7"]]
    assert json.loads(Path("j").read_text())["device"] == 7


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("image", "image: name the file, model or table to send"),
        ("install", "install: name the file, model or table to send"),
        ("status 5", "status: takes no value"),
        ("start 5", "start: takes no value"),
        ("identify 5", "identify: takes no value"),
        ("reference high", "high: is no number; the reference is a displacement in um"),
        ("record", "record: name the file, model or table to send"),
        ("record table", "record: name the file: -o FILE"),
        ("start -o x.csv", "start: takes no -o"),
        ("install appendix_a", "install: name the file: --key FILE"),
        ("start --key key", "start: takes no --key"),
        ("image none", "none: cannot be read (No such file or directory)"),
    ],
)
def test_link_refuses_what_an_action_does_not_take(
    words: str, message: str, firmware: Firmware, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["link", "port", *words.split()]) == 2
    assert message in capsys.readouterr().err
    assert not [call for call in firmware.calls if call[0] in ("install", "reference", "request")]


@pytest.mark.parametrize("equal", [True, False])
def test_the_demo_goes_the_whole_way_and_shows_each_command(
    equal: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    model, given = replace(load_model("appendix_a"), name="stage"), list[Any]()
    results: list[Any] = []
    study = SimpleNamespace(
        ladder=lambda: [["step", *["x"] * 8]], diagnosis=SimpleNamespace(base=model), to_json=lambda: {"causes": []}
    )
    report = SimpleNamespace(
        equal=equal, lines=lambda: ["first", "equal in every bit"], to_json=lambda: {"equal": equal}
    )
    price = SimpleNamespace(to_json=lambda: {"cycles": 5})

    def page(*words: Any, **named: Any) -> Any:
        given.append((words, named))
        return SimpleNamespace(html=lambda: "<html>hysgen</html>")

    def diagnosed(record: Any, holdout: Any, settings: Any, progress: Any) -> Any:
        given.append((record.samples, settings.identify * record.samples))
        return study

    monkeypatch.setattr(demo, "toolchains", lambda *given: None)
    monkeypatch.setattr(demo, "diagnose", diagnosed)
    monkeypatch.setattr(demo, "verdict", lambda _: ["the verdict"])
    monkeypatch.setattr(demo, "scored_extension", lambda _: model)
    monkeypatch.setattr(demo, "verify", lambda folder, samples, _: given.append((folder, samples)) or report)
    monkeypatch.setattr(demo, "cost", lambda folder: given.append(folder) or price)
    monkeypatch.setattr(demo, "cost_text", lambda *_: "the cost")
    monkeypatch.setattr(demo, "diagnosis_page", page)
    monkeypatch.setattr(Console, "write_json", lambda _, result: results.append(result))
    assert main(["-q", "demo", "-o", "d", "--samples", "77"]) == (0 if equal else 1)
    (samples, identified), (code, compared), costed, (words, named) = given
    assert identified == pytest.approx(IDENTIFICATION_ROWS)
    assert samples > IDENTIFICATION_ROWS
    assert (code, compared, costed) == (Path("d/c"), 77, Path("d/c"))
    assert words == (study,)
    assert named["proof"] == (report, price)
    assert Path("d/record.csv").read_text() == bundled_csv()
    assert {path.name for path in Path("d").iterdir()} == {"record.csv", "paper.json", "stage.json", "report.html", "c"}
    assert (Path("d/c/stage.c").exists(), Path("d/report.html").read_text()) == (True, "<html>hysgen</html>")
    lines = capsys.readouterr().out.splitlines()
    commands = [
        f"$ hysgen diagnose d/record.csv --rows 0:{IDENTIFICATION_ROWS} -o d/stage.json --report d/report.html",
        "$ hysgen generate d/stage.json -o d/c",
        "$ hysgen verify d/c --samples 77",
        "$ hysgen cost d/c",
    ]
    assert [line for line in lines if line.startswith("$")] == commands
    assert named["command"] == commands[0][2:]
    for line in ("the verdict", "equal in every bit", "the cost"):
        assert line in lines
    assert lines[-1].endswith("s; the page with pictures: d/report.html; models: d/stage.json, d/paper.json")
    (told,) = results
    assert (told["verify"], told["cost"], told["report"]) == ({"equal": equal}, {"cycles": 5}, "d/report.html")
    assert 0.0 <= told["seconds"] < 60.0
