"""Width and time of lines, JSON, exit codes, and how each option is read."""

import io
import itertools
import json
import os
import shlex
import stat
import sys
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hysgen.cli import main
from hysgen.cli.console import Console, ProgressLine, command_line, folded
from hysgen.cli.main import overview, parser
from hysgen.cli.options import parse_rows, with_learner
from hysgen.cli.verbs import NAMES, check_device, check_file, check_files, check_writable, written_by_hysgen
from hysgen.display import table
from hysgen.errors import HysgenError, RecordError
from hysgen.machine.files import version
from hysgen.model.file import load_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.targets import Target


class Terminal(io.StringIO):
    """A stream that is a terminal and counts how often it was flushed."""

    flushed = 0

    def isatty(self) -> bool:
        return True

    def flush(self) -> None:
        self.flushed += 1


# Folding


def test_a_column_is_not_narrowed_below_ten_and_a_table_ends_with_its_rows() -> None:
    text = table(["a", "b"], [["x" * 4 + " " + "y" * 10, "z" * 9 + " zz"]], left=2)
    assert len(text.split("\n")[1]) == 15 + 2 + 12
    narrowest = folded(text, 22)
    assert narrowest.split("\n")[1] == "-" * 10 + "  " + "-" * 10
    assert folded(text, 21) == text, "what does not fit stays as it is"
    behind = f"{text}\na sentence that writes across the columns of the table"
    assert folded(behind, 24).split("\n")[-1].startswith("    "), "it is folded as a sentence"


def test_a_stream_without_the_letters_of_a_picture_gets_a_sign_in_their_place() -> None:
    out = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    Console(out=out).say("\u28c0 5 ± 1")
    assert out.buffer.getvalue() == b"? 5 \xb1 1\n"  # type: ignore[attr-defined]


# Progress


def test_a_terminal_has_one_line_cut_to_its_width_and_cleared_for_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "20")
    err = Terminal()
    line = ProgressLine(err)
    line.show(0.25, "fitting a long name of a step")
    assert err.getvalue() == "\r\x1b[K 25.0 %  fitting a "
    assert len(err.getvalue()) == 4 + 19
    assert err.flushed == 1
    line.pause()
    assert err.getvalue().endswith("\r\x1b[K")
    line.pause()
    assert err.getvalue().count("\r\x1b[K") == 2, "nothing is left to clear"
    line.stop()
    assert line._thread is not None
    assert not line._thread.is_alive()


@pytest.mark.parametrize(("stream", "interval"), [(Terminal(), 0.5), (io.StringIO(), 2.0)], ids=["terminal", "file"])
def test_lines_follow_each_other_at_most_in_an_interval(
    stream: io.StringIO, interval: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 1000.0
    monkeypatch.setattr("hysgen.cli.console.time.monotonic", lambda: now)
    monkeypatch.setattr(ProgressLine, "_repeat", lambda self: None)
    line = ProgressLine(stream, started=1000.0)
    for at, fraction in (
        (0.0, 0.1),
        (interval - 0.01, 0.2),
        (interval, 0.3),
        (interval + 0.1, 0.4),
        (interval + 0.2, 1.0),
    ):
        now = 1000.0 + at
        line.show(fraction, "step")
    shown = [
        float(part.partition("%")[0]) for part in stream.getvalue().replace("\r\x1b[K", "\n").split("\n") if "%" in part
    ]
    assert shown == [10.0, 30.0, 100.0], "the end is always said"


@pytest.mark.parametrize(
    ("passed", "fraction", "text"),
    [
        (2.99, 0.5, ""),
        (3.0, 0.5, "  (3 s, about 3 s left)"),
        (10.0, 0.05, "  (10 s)"),
        (10.0, 0.0501, "  (10 s, about 190 s left)"),
        (10.0, 1.0, "  (10 s)"),
        (10.0, 0.954, "  (10 s)"),
        (10.0, 0.952, "  (10 s, about 1 s left)"),
    ],
)
def test_time_is_said_from_three_seconds_and_five_percent_on(
    passed: float, fraction: float, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hysgen.cli.console.time.monotonic", lambda: 100.0 + passed)
    err = io.StringIO()
    line = ProgressLine(err, verbose=True, started=100.0)
    line.show(fraction, "x")
    line.stop()
    assert err.getvalue() == f"{100 * fraction:5.1f} %  x{text}\n"


# Console


def test_json_is_readable_with_a_head_unless_the_result_has_its_own(tmp_path: Path) -> None:
    out = io.StringIO()
    console = Console(json_to="-", out=out, verb="schema")
    console.say("text")
    assert console.finish({"schemas": ["\N{MICRO SIGN}m"]}, holds=False) == 1
    head = f'{{\n  "schema": "hysgen-schema",\n  "version": 1,\n  "hysgen": "{version()}",\n'
    assert out.getvalue() == head + '  "schemas": [\n    "\N{MICRO SIGN}m"\n  ]\n}\n'
    own = {"schema": "own", "a": 1}
    assert console.with_head(own) is own
    with pytest.raises(ValueError, match="JSON"):
        console.write_json({"schemas": [], "more": float("nan")})
    Console(json_to=None).write_json({"a": float("nan")})


@pytest.mark.parametrize(
    ("program", "known"),
    [("/bin/hysgen", True), ("/p/hysgen/__main__.py", True), ("/p/other/__main__.py", False), ("/bin/pytest", False)],
)
def test_the_command_line_of_a_report_is_hysgens_own(
    program: str, known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [program, "fit", "a b.csv"])
    assert command_line() == ("hysgen fit 'a b.csv'" if known else "")


# Outputs


def test_a_file_of_hysgen_names_it_in_its_head(tmp_path: Path) -> None:
    path = tmp_path / "x"
    for content, own in (
        (b"", True),
        (b"HYSI\x02", True),
        (b"a" * (16_384 - 6) + b"hysgen", True),
        (b"a" * (16_384 - 5) + b"hysgen", False),
    ):  # fmt: skip
        path.write_bytes(content)
        assert written_by_hysgen(path) == own
    with pytest.raises(HysgenError, match=r"--to .*x: exists, and hysgen did not write it"):
        check_file(path, "--to")
    check_file(path, "--to", force=True)
    with pytest.raises(HysgenError, match=f"-o {tmp_path}: is a folder; name a file in it"):
        check_file(tmp_path, "-o", force=True)
    assert not written_by_hysgen(tmp_path / "missing")
    manifest = tmp_path / "MANIFEST.json"
    for schema, known in (("hysgen-manifest", True), ("other", False)):
        manifest.write_text(json.dumps({"schema": schema, "model": "m", "files": {"x": 1}}))
        if known:
            check_files(tmp_path, ["x"], "-o", force=False)
        else:
            with pytest.raises(HysgenError, match="exists"):
                check_files(tmp_path, ["x"], "-o", force=False)


def test_a_folder_is_tried_where_it_will_be_made(tmp_path: Path) -> None:
    check_writable(tmp_path / "new" / "folder")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    with pytest.raises(HysgenError, match=r"file/new: cannot be written \(.*/file is no folder\)"):
        check_writable(tmp_path / "file" / "new")


def test_a_disk_is_refused_and_a_pipe_is_not_opened(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    check_device(tmp_path / "pipe", "-o")  # opening it would wait for a reader
    monkeypatch.setattr(Path, "stat", lambda self: SimpleNamespace(st_mode=stat.S_IFBLK))
    with pytest.raises(HysgenError, match="-o disk: is a disk; name a file"):
        check_device(Path("disk"), "-o")


# The call as a whole


@pytest.mark.parametrize(
    ("call", "code", "words"),
    [
        ("", 2, "usage: hysgen VERB"),
        ("help", 0, "usage: hysgen VERB"),
        ("-h", 0, "usage: hysgen VERB"),
        ("-V", 0, "hysgen "),
        ("completion fish", 0, "complete -c hysgen -n '__fish_seen_subcommand_from fit' -l rules"),
        ("completion bash extra", 2, "completion: name a shell out of bash, zsh, fish"),
        ("completion csh", 2, "completion: name a shell out of"),
        ("help image", 0, "usage: hysgen image"),
        ("-q -v schema", 0, "score-1"),
    ],
)
def test_a_call_without_work_has_its_text_and_code(
    call: str, code: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        answer: Any = main(call.split())
    except SystemExit as left:
        answer = left.code or 0
    captured = capsys.readouterr()
    assert answer == code
    assert words in captured.out + captured.err
    assert captured.err.count("\n") == (code == 2 and call != "")


def test_the_overview_sets_meanings_beside_commands_where_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """The longest of the first steps has 36 columns with its margin; 24 are left from 60 on."""
    for columns, beside in ((120, True), (100, True), (40, False)):
        monkeypatch.setenv("COLUMNS", str(columns))
        lines = overview().split("\n")
        assert any(line.startswith("  hysgen demo ") for line in lines) == beside
        assert max(len(line) for line in lines if not line.startswith("  hysgen")) <= columns
        for name in NAMES:
            assert any(line.split()[:1] == [name] for line in lines)
        first = lines.index("first steps:")
        for above, line in itertools.pairwise(lines[: lines.index("", first)]):
            at = len(line) - len(line.lstrip())
            assert at <= 2 or above[at - 1] == " " != above[at] or (above in lines[first:] and not beside and at == 6)
    longest = max(len(line) for line in ("hysgen diagnose record.csv -o stage.json", "hysgen generate stage.json -o c"))
    for columns in (longest + 4 + 24, longest + 4 + 23):
        monkeypatch.setenv("COLUMNS", str(columns))
        assert ("  hysgen demo " in overview()) == (columns == longest + 28)


CALLS: Mapping[str, dict[str, Any]] = {
    "demo": {"output": "hysgen-demo", "samples": 50_000},
    "demo -o d --samples 7": {"output": "d", "samples": 7},
    "diagnose a.csv --rows 1:2 --holdout b.csv c.csv -o m --plots p --report r.html --keep-all --rules 7": {
        "records": ["a.csv"], "rows": "1:2", "holdout": ["b.csv", "c.csv"], "output": "m", "plots": "p",
        "report": "r.html", "keep_all": True, "rules": 7,
    },
    "diagnose a.csv": {"keep_all": False, "rules": 6, "holdout": None, "split_at_gaps": False, "accept": []},
    "fit a.csv -o m --name n --forgetting 0.9 --alpha 3 --epsilon 2 --margin 0.5 --input-range 1 2 --memory": {
        "name": "n", "forgetting": 0.9, "alpha": 3.0, "epsilon": 2.0, "margin": 0.5, "input_range": [1.0, 2.0],
        "memory": 8, "relaxation": False, "uncertified": False,
    },
    "fit a.csv -o m --memory 3 --relaxation --uncertified --learn bias --learn-alpha 5 --learn-forgetting 0.95": {
        "memory": 3, "relaxation": True, "uncertified": True, "learn": "bias", "learn_alpha": 5.0,
        "learn_forgetting": 0.95, "learn_noise": None,
    },
    "export m --to cmake -o d --check 4 --elf e --instance i --learner l": {
        "to": "cmake", "check": 4, "elf": "e", "instance": "i", "learner": "l",
    },
    "firmware m -o d --samples 9 --kernels c674x": {"output": "d", "samples": 9, "kernels": "c674x"},
    "firmware m": {"samples": 12_000, "output": None},
    "image m -o f --flashed g --key k --device ab --counter 3": {
        "output": "f", "flashed": "g", "key": "k", "device": "ab", "counter": 3,
    },
    "image m -o f --key k": {"device": "0", "counter": 1, "key": "k", "flashed": None},
    "refit m a.csv -o n --c d --same-range --anyway --no-diagnosis": {
        "c": "d", "same_range": True, "anyway": True, "no_diagnosis": True,
    },
    "refit m a.csv -o n": {"c": None, "same_range": False, "anyway": False, "no_diagnosis": False},
    "score m a.csv --settle 3 --rivals 0:5": {"settle": 3, "rivals": "0:5"},
    "compare m n a.csv --rows 5:": {"files": ["m", "n", "a.csv"], "rows": "5:"},
    "link port": {"action": "status", "value": None, "baud": 115_200},
    "link port reference 2.5 --baud 9600 --key k": {"action": "reference", "value": "2.5", "baud": 9600, "key": "k"},
    "prove d --samples 5 --calls a,b": {"samples": 5, "calls": "a,b"},
    "prove d": {"samples": 100_000, "calls": ""},
    "verify d": {"samples": None, "updates": None, "seed": 1, "target": None, "machine": None},
    "inspect a.csv --accept clipped --jitter 0.5 --split-at-gaps": {
        "accept": ["clipped"], "jitter": 0.5, "split_at_gaps": True,
    },
}  # fmt: skip


@pytest.mark.parametrize("call", CALLS, ids=str)
def test_every_option_is_read_and_has_the_default_that_its_help_states(call: str) -> None:
    words = shlex.split(call)
    if "--accept" in words:
        from hysgen.record.checks import ACCEPTABLE

        words[words.index("--accept") + 1] = ACCEPTABLE[0]
    given = vars(parser([words[0]]).parse_args(words))
    expected = CALLS[call] | ({"accept": [words[words.index("--accept") + 1]]} if "--accept" in words else {})
    read = {name: value.name if isinstance(value := given[name], Target) else value for name in expected}
    assert read == expected
    assert (given["json"], given["force"], given["quiet"], given["verbose"]) == (None, False, False, False)


def test_rows_end_with_the_record_and_hold_one_sample_at_least() -> None:
    for text, rows in (("0:7100", (0, 7100)), ("7099:", (7099, 7100)), (":1", (0, 1)), ("-7100:-1ms", (0, 7099))):
        assert parse_rows(text, 7100, 1e-3) == rows
    for text in ("0:7101", "5:5", "6:5", "-7101:", "5", "a:b", "1:2x"):
        with pytest.raises(RecordError, match="is not a range of the record's 7100 samples"):
            parse_rows(text, 7100, 1e-3)


def test_a_learner_is_changed_only_by_what_is_given() -> None:
    plain = load_model("appendix_a")

    def learner(model: Any, **given: Any) -> Any:
        options = {"learn": None, "learn_forgetting": None, "learn_alpha": None, "learn_noise": None}
        return with_learner(model, SimpleNamespace(**(options | given)))  # type: ignore[arg-type]

    assert learner(plain) is plain
    assert learner(plain, learn_alpha=5.0).learner == LearnerSettings(alpha=5.0)
    noisy = learner(plain, learn="bias", learn_noise=0.01, learn_forgetting=0.99)
    assert noisy.learner == LearnerSettings(learned=("bias",), noise_um=0.01, forgetting=0.99)
    assert learner(noisy, learn_alpha=7.0).learner == LearnerSettings(
        learned=("bias",), noise_um=0.01, forgetting=0.99, alpha=7.0
    )
    assert learner(noisy, learn="none", learn_alpha=7.0).learner is None
