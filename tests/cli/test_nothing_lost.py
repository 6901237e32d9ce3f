"""No input and no file of the user is overwritten; outputs are tried first; a machine's faults are one line, exit 2."""

import importlib
import os
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from pathlib import Path

import pytest

from hysgen.cli import main
from hysgen.errors import HysgenError
from hysgen.machine import kernel_build, native
from hysgen.machine.processes import processes
from hysgen.model.file import load_model
from hysgen.record.read import bundled_csv

ROWS = "time_s,voltage_V,displacement_um\n" + "".join(f"{k * 1e-3:.3f},{k % 7},{k % 5}\n" for k in range(50))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a record and a document of the user."""
    monkeypatch.chdir(tmp_path)
    Path("ok.csv").write_text(ROWS)
    Path("thesis.html").write_text("<p>mine</p>")
    Path("c").mkdir()
    Path("c/appendix_a.h").write_text("/* mine */\n")
    Path("ours").mkdir()
    Path("ours/MANIFEST.json").write_text('{"schema": "hysgen-manifest", "model": "appendix_a", "files": {}}')
    return tmp_path


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("fit ok.csv -o ok.csv", "-o ok.csv: is an input of this call"),
        ("fit ok.csv -o -", "-o -: is written to a file only"),
        ("fit ./ok.csv -o x.json --json ok.csv", "--json ok.csv: is an input of this call"),
        ("fit ok.csv -o x.json --json x.json", "-o x.json: is the file of --json too"),
        ("diagnose ok.csv --report thesis.html", "exists, and hysgen did not write it"),
        ("diagnose ok.csv --report r.pdf", "--report r.pdf: writes .html"),
        ("score appendix_a ok.csv --plot x.bmp", "--plot x.bmp: writes .png"),
        ("generate appendix_a -o ok.csv", "-o ok.csv: is a file; name a folder"),
        ("generate appendix_a -o c", "c/appendix_a.h: exists, and hysgen did not write it"),
        ("export appendix_a --to cmake -o c", "-o c: holds files of others"),
        ("generate appendix_b -o ours", "ours: holds the C of appendix_a, not of appendix_b; name another folder"),
        ("fit ok.csv -o /proc/nowhere/x.json", "cannot be written"),
        ("demo -o .", "record.csv: exists, and hysgen did not write it"),
    ],
)
def test_an_output_that_would_replace_a_file_of_the_user_is_refused(
    call: str, said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("record.csv").write_text(ROWS)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(call.split()) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""  # refused before anything is computed
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_files_of_hysgen_are_written_again_and_others_with_force(folder: Path) -> None:
    assert main(["generate", "appendix_a", "-o", "new"]) == 0
    assert main(["generate", "appendix_a", "-o", "new"]) == 0
    assert main(["generate", "appendix_a", "-o", "c", "--force"]) == 0
    assert main(["describe", "appendix_a", "--json", "d.json"]) == 0
    assert main(["describe", "appendix_a", "--json", "d.json"]) == 0


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (MemoryError("919 MiB"), "not enough memory (919 MiB)"),
        (OSError(28, "No space left on device"), "No space left"),
    ],
)
def test_faults_of_the_machine_are_one_line_and_exit_code_2(
    fault: Exception, said: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise fault

    monkeypatch.setattr("hysgen.cli.verbs.fit.read_records", fails)
    assert main(["fit", "ok.csv", "-o", "x.json"]) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is of Linux")
@pytest.mark.parametrize(
    "call",
    [
        "fit ok.csv -o x.json --json /dev/full",
        "fit ok.csv -o /dev/full",
        "score appendix_a ok.csv --json /dev/full",
        "diagnose ok.csv --json /dev/full",
        "inspect ok.csv --json /dev/full",
        "cost appendix_a --json /dev/full",
    ],
)
def test_a_full_device_is_found_before_the_computation(
    call: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(call.split()) == 2
    captured = capsys.readouterr()
    assert "/dev/full: cannot be written (No space left on device)" in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert not Path("x.json").exists()


def test_a_demo_without_a_compiler_says_so_before_the_diagnosis(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", f"{folder}")
    monkeypatch.setattr(kernel_build, "_packaged_call", list)
    assert main(["demo", "-o", "new"]) == 2
    captured = capsys.readouterr()
    assert captured.err.endswith(
        "none of gcc, clang, cc is installed; install gcc or clang, or point CC at one; "
        "or, with pip alone, `pip install 'hysgen[compiler]'`\n"
    )
    assert (captured.err.count("\n"), captured.out, Path("new").exists()) == (1, "", False)


def test_a_device_or_a_pipe_that_takes_the_output_gets_it(folder: Path) -> None:
    assert main(["describe", "appendix_a", "--json", "/dev/null"]) == 0
    os.mkfifo("pipe")
    with ThreadPoolExecutor(1) as beside:
        read = beside.submit(Path("pipe").read_text)
        assert main(["describe", "appendix_a", "--json", "pipe"]) == 0
        assert '"hysgen-describe"' in read.result(timeout=600)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is of Linux")
def test_a_full_stdout_is_one_line_and_exit_code_2() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "hysgen", "--version"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not enforce a limit of the address space")
@pytest.mark.parametrize("limit_kB", [100_000, 200_000, 350_000, 420_000])
def test_a_limit_of_the_memory_is_one_line_or_the_result(limit_kB: int, folder: Path) -> None:
    # OpenBLAS without a buffer ends the process with a message of its own, or tries again without end (350000).
    record = Path(str(resources.files("hysgen"))) / "record" / "demo_stage.csv"
    Path("part.csv").write_text("".join(record.read_text().splitlines(keepends=True)[:3001]))
    done = subprocess.run(
        [sys.executable, "-m", "hysgen", "fit", "part.csv", "-o", "x.json", "--quiet"],
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit_kB * 1024,) * 2),
    )
    if done.returncode == 0:
        assert Path("x.json").exists()
    else:
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert done.stderr.startswith("hysgen fit: not enough memory")


def test_a_library_that_cannot_be_loaded_is_one_line_and_exit_code_2(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object) -> None:
        raise ImportError("libhdf5.so: failed to map segment from shared object")

    monkeypatch.setattr(importlib.import_module("hysgen.cli.main"), "verb", fails)
    assert main(["fit", "ok.csv", "-o", "x.json"]) == 2
    captured = capsys.readouterr()
    assert "a library cannot be loaded (libhdf5.so: failed to map segment" in captured.err
    assert captured.err.count("\n") == 1


def test_a_cache_that_cannot_be_written_falls_back_to_a_temporary_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    blocked = tmp_path / "a-file"
    blocked.write_text("")
    native._usable.cache_clear()
    monkeypatch.delenv("HYSGEN_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert native.cache_folder() == tmp_path / f"hysgen-{os.getuid()}"
    # A folder that somebody else may write to is not used: its libraries would be opened.
    native._usable.cache_clear()
    (tmp_path / f"hysgen-{os.getuid()}").chmod(0o777)
    with pytest.raises(HysgenError, match="point HYSGEN_CACHE at a folder with room"):
        native.cache_folder()
    monkeypatch.setenv("HYSGEN_CACHE", str(blocked / "x"))
    with pytest.raises(HysgenError, match=r"HYSGEN_CACHE=.*x: cannot be written; name another folder"):
        native.cache_folder()
    native._usable.cache_clear()


def test_help_lists_the_verbs_in_groups_and_loads_no_library() -> None:
    code = (
        "import sys; from hysgen.cli import main; assert main(['--help']) == 0\n"
        "assert not {'numpy', 'scipy', 'matplotlib'} & set(sys.modules), 'slow'\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.index("  diagnose") < done.stdout.index("  generate") < done.stdout.index("  demo")


def test_a_home_that_cannot_be_written_gives_the_pictures_another_folder(
    folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Otherwise matplotlib prints two lines of its own."""
    monkeypatch.setenv("HOME", "/proc/nowhere")
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("MPLCONFIGDIR", "unset below")
    monkeypatch.delenv("MPLCONFIGDIR")
    assert main(["describe", "appendix_a", "-q"]) == 0
    assert os.environ["MPLCONFIGDIR"] == str(tmp_path / "cache" / "matplotlib")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("MPLCONFIGDIR")
    assert main(["describe", "appendix_a", "-q"]) == 0
    assert "MPLCONFIGDIR" not in os.environ


@pytest.mark.parametrize("closed", [1, 2])
@pytest.mark.slow
def test_a_job_without_standard_streams_is_done(closed: int, folder: Path) -> None:
    command = f"{sys.executable} -m hysgen describe appendix_a --json d.json {closed}>&-"
    own = {**os.environ, "PYTHONPATH": str(Path(native.__file__).parents[2])}
    assert subprocess.run(["sh", "-c", command], check=False, env=own).returncode == 0
    assert (folder / "d.json").stat().st_size > 100


@pytest.mark.parametrize("text", ["two", "0", "-3", "1.5"])
def test_a_number_of_processes_that_is_none_is_refused(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYSGEN_PROCESSES", text)
    with pytest.raises(HysgenError, match=rf"HYSGEN_PROCESSES={text}: is no number of processes; give 1 or more"):
        processes()


@pytest.mark.slow
def test_a_reader_that_closes_the_pipe_loses_no_file(folder: Path) -> None:
    """`hysgen refit ... | head -1` ended without the model, and with 0."""
    Path("ok.csv").write_text("".join(bundled_csv().splitlines(keepends=True)[:3001]))
    own = {**os.environ, "PYTHONPATH": str(Path(native.__file__).parents[2])}
    first = [sys.executable, "-m", "hysgen", "fit", "ok.csv", "-o", "a.json", "--method", "batch", "-q"]
    subprocess.run(first, check=True, env=own, stdout=subprocess.DEVNULL)
    for name, pipe in {"b.json": "-q | true", "c.json": "-v 2>&1 | true"}.items():
        again = f"{sys.executable} -m hysgen refit a.json ok.csv -o {name} --anyway {pipe}"
        subprocess.run(["sh", "-c", again], check=True, env=own)
        assert load_model(name).name == "a"


def test_an_interrupt_while_modules_are_loaded_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Interrupts:
        @property
        def main(self) -> None:
            raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "hysgen.cli", Interrupts())
    assert importlib.import_module("hysgen.__main__").run() == 130
    assert capsys.readouterr().err == "\nhysgen: interrupted before anything was done\n"


@pytest.mark.slow
def test_no_verb_but_the_demo_loads_pictures_before_they_are_asked_for() -> None:
    code = (
        "import sys; from hysgen.cli.verbs import NAMES, verb\n"
        "for name in NAMES:\n"
        "    if name != 'demo':\n"
        "        verb(name)\n"
        "        assert 'matplotlib' not in sys.modules, name\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
