"""Help, completion, project file, stdin, rows in seconds, width of the terminal, quiet and verbose."""

import contextlib
import io
import json
import subprocess
import sys
import time
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hysgen.cli import main
from hysgen.cli.console import Console, ProgressLine, folded
from hysgen.cli.main import options_of, parser, script
from hysgen.cli.verbs import NAMES
from hysgen.display import table
from hysgen.errors import RecordError
from hysgen.record import load_record
from hysgen.record.read import bundled_csv

HEAD = "\n".join(bundled_csv().splitlines()[:2001]) + "\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("r.csv").write_text(HEAD.replace("time_s,voltage_V,displacement_um", "t,a,b"))
    return tmp_path


def test_a_project_file_holds_options_and_the_command_line_wins(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", "r.csv"]) == 2
    Path("hysgen.toml").write_text('[record]\ncolumns = "time=t,voltage=a,displacement=b"\n[fit]\nrules = 4\n')
    assert main(["inspect", "r.csv"]) == 0
    assert main(["fit", "r.csv", "-o", "a.json", "--method", "batch"]) == 0
    assert "(4 rules" in capsys.readouterr().out
    assert main(["fit", "r.csv", "-o", "a.json", "--method", "batch", "--rules", "5"]) == 0
    assert "(5 rules" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[fit]\nrulez = 4", "hysgen fit has no option --rulez"),
        ("[polish]\nx = 1", "[polish] is no verb"),
        ("rules = 4", "rules stands outside a table"),
        ("[fit]\nrules = 'many'", "rules = 'many' does not suit --rules"),
        ("[fit]\nmethod = 'magic'", "method = 'magic': choose from rls, batch, refined"),
        ("[fit", "hysgen.toml: cannot be read"),
        ('[record]\ncolums = "time=t"', "[record] colums: hysgen fit has no option --colums (did you mean 'columns'?)"),
    ],
)
def test_a_fault_in_the_project_file_is_one_line(
    text: str, said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("hysgen.toml").write_text(text)
    assert main(["fit", "r.csv", "-o", "a.json"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_a_record_comes_from_stdin() -> None:
    call = [sys.executable, "-m", "hysgen", "inspect", "-", "--rows", "0s:20ms"]
    done = subprocess.run(call, input=HEAD, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "1000 samples at 50 kHz" in done.stdout


def test_completion_knows_every_verb_and_option() -> None:
    options = options_of(parser())
    assert tuple(options) == NAMES
    for shell in ("bash", "zsh", "fish"):
        text = script(shell, options)
        assert all(name in text for name in NAMES)
    bash = subprocess.run(["bash", "-n"], input=script("bash", options), capture_output=True, text=True, check=False)
    assert bash.returncode == 0, bash.stderr


def test_options_out_of_range_are_said_before_the_computation(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit = ["fit", "r.csv", "-o", "m.json", "--method", "batch", "--columns", "time=t,voltage=a,displacement=b"]
    for option, said in (
        (["--rules", "300"], "--rules 300: is not supported; choose 2 to 64"),
        (["--jitter", "-1"], "jitter: -1 is no share of the sampling period"),
    ):
        assert main([*fit, *option]) == 2
        err = capsys.readouterr().err
        assert said in err
        assert "rules see fewer" not in err
    assert main([*fit, "--input-range", "-1000", "1000"]) == 0
    assert "--input-range: 2000 V is more than 2 times" in capsys.readouterr().err


def test_schemas_are_listed_printed_and_exist_for_every_verb(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    listed = capsys.readouterr().out.split()
    assert {f"{name}-1" for name in NAMES if name != "fit"} | {"model-1", "manifest-1"} <= set(listed)
    assert main(["schema", "hysgen-score"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["$id"] == "hysgen-score-1"
    assert "free_run" in schema["required"]
    assert main(["schema", "fit"]) == 0
    assert '"$id": "hysgen-model-1"' in capsys.readouterr().out
    assert main(["schema", "scores"]) == 2
    assert "scores: no such schema; choose from" in capsys.readouterr().err


def test_a_result_that_breaks_its_schema_is_found() -> None:
    """The fixture of conftest.py holds every result of every verb to its schema; here one breaks it."""
    with pytest.raises(jsonschema.ValidationError, match="'record' is a required property"):
        Console(verb="score").finish({"model": "x"})


def test_the_time_left_does_not_rise_within_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("hysgen.cli.console.time.monotonic", lambda: now)
    err = io.StringIO()
    line = ProgressLine(err, verbose=True, started=80.0)
    for seconds in range(0, 25, 5):
        now = 100.0 + seconds
        line.show(0.5, "searching")
    line.stop()
    left = [text.partition("about ")[2].partition(" s left")[0] for text in err.getvalue().splitlines()]
    assert left == ["20", "15", "10", "5", ""]


def test_progress_is_repeated_while_a_computation_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hysgen.cli.console.SECONDS", 0.1)
    err = io.StringIO()
    console = Console(err=err)
    console.progress(0.2, "searching")
    time.sleep(0.7)
    assert err.getvalue().count("20.0 %  searching") >= 2
    console.say("")
    told = err.getvalue()
    time.sleep(0.4)
    assert err.getvalue() == told, "text follows, so nothing is repeated"
    console.close()


def test_a_big_file_that_is_read_shows_progress(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hysgen.cli.options.BIG_BYTES", 99)
    assert main(["inspect", "r.csv", "--columns", "time=t,voltage=a,displacement=b"]) == 0
    assert "reading 0 MB" in capsys.readouterr().err
    for verb, columns in (("simulate", "voltage=a"), ("waveform", "displacement=b")):
        main([verb, "appendix_a", "r.csv", "--columns", f"time=t,{columns}", "-v"])
        assert "reading 0 MB" in capsys.readouterr().err


def test_two_models_of_one_name_are_told_apart_by_their_files(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = ["--columns", "time=t,voltage=a,displacement=b"]
    assert main(["fit", "r.csv", *columns, "-o", "a.json", "--method", "batch", "-q"]) == 0
    Path("b.json").write_text(Path("a.json").read_text())
    capsys.readouterr()
    assert main(["diff", "a.json", "b.json", "-q"]) == 0
    assert "a.json -> b.json" in capsys.readouterr().out


def test_an_open_file_is_refused_for_its_path(folder: Path) -> None:
    with Path("r.csv").open() as opened, pytest.raises(RecordError, match=r"an open file is no name .* give its path"):
        load_record(opened)  # type: ignore[arg-type]


@pytest.mark.parametrize("columns", [60, 80])
def test_help_and_tables_of_text_fit_the_terminal(
    columns: int, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    calls = [["--help"], ["describe", "--help"], ["inspect", "r.csv", "--columns", "time=t,voltage=a,displacement=b"]]
    for call in calls:
        with contextlib.suppress(SystemExit):
            main(call)
        wide = [line for line in capsys.readouterr().out.splitlines() if len(line) > columns]
        assert [line for line in wide if not line.startswith("  hysgen ")] == []


@given(
    st.lists(st.lists(st.sampled_from(["a", "creep", "swings", "longest"]), min_size=1, max_size=12), min_size=1),
    st.integers(34, 70),
)
def test_a_table_of_text_is_folded_to_the_width_and_keeps_every_word(rows: list[list[str]], width: int) -> None:
    cells = [["cause", "no", " ".join(words)] for words in rows]
    text = table(["cause", "excited", "because"], cells, 3)
    lines = folded(text, width).splitlines()
    assert max(map(len, lines)) <= max(width, 0)
    assert sorted(" ".join(line for line in lines if "--" not in line).split()) == sorted(
        word for line in text.splitlines() if "--" not in line for word in line.split()
    )
    if max(map(len, text.splitlines())) <= width:
        assert lines == text.splitlines()


KILL = "os.kill(os.getpid(), signal.SIGINT)"


@pytest.mark.parametrize(
    "within", [KILL, "exec('raise KeyboardInterrupt')", f"weakref.ref(set(), lambda _: {KILL}), time.sleep(0.5)"]
)
def test_an_interrupt_is_one_line_and_a_code_also_in_executed_texts_and_callbacks(within: str) -> None:
    """Dataclasses are made by such texts; CPython then ends by the signal after the line, or drops the interrupt."""
    program = (
        "import os, signal, sys, time, weakref, hysgen.cli as cli\nfrom hysgen.__main__ import run\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"cli.main = lambda: ({within})\nsys.exit(run())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 130, done
    assert done.stderr.strip() == "hysgen: interrupted before anything was done"


@pytest.mark.parametrize("fault", ["nan", "1.#INF", "9.9e37"])
def test_rows_behind_those_that_are_asked_for_refuse_nothing(
    fault: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = HEAD.splitlines()
    lines[1801] = f"{lines[1801].rpartition(',')[0]},{fault}"
    Path("late.csv").write_text("\n".join([lines[0], "", *lines[1:]]))
    assert main(["fit", "late.csv", "--rows", "0:1802", "-o", "a.json"]) == 2
    assert main(["fit", "late.csv", "--rows", "0:1800", "-o", "a.json"]) == 0
    assert (
        "late.csv: the rows from 1800 on are left out: late.csv: line 1803: displacement_um" in capsys.readouterr().err
    )
    Path("sound.csv").write_text("\n".join(lines[:1801]))
    assert main(["fit", "sound.csv", "-o", "b.json"]) == 0
    both = (json.loads(Path(name).read_text())["consequents"] for name in ("a.json", "b.json"))
    assert next(both) == next(both)


def test_a_stroke_of_nanometres_is_scored_with_the_digits_that_matter(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = [line.split(",") for line in HEAD.splitlines()[1:]]
    rows = (f"{one[0]},{one[1]},{1e-3 * float(one[2])!r}" for one in record)
    Path("nm.csv").write_text("\n".join(["time_s,voltage_V,displacement_um", *rows]))
    assert main(["fit", "nm.csv", "-o", "nm.json"]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("free run  "))
    assert len(line.split()[2].strip("0.")) >= 3
