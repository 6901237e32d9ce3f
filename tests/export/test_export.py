"""Exports: every target computes the bits of the generated C, its folder works as it is, one more is one file."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fixtures import proof_models
from fixtures.exported_folders import NAME, TOOLS, exported, model
from fixtures.tools import library, need
from hysgen.checking import Host
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.errors import BudgetError, HysgenError
from hysgen.export import Reference, compare, export_texts, exports, inputs, write_export
from hysgen.export.base import MODES, Samples
from hysgen.export.fmu import archive
from hysgen.float32.struct_words import Commit
from hysgen.machine.files import digest
from hysgen.model.file import load_model

SAMPLES = 2500
RUNNING = [name for name, export in exports().items() if export.ways]


@pytest.mark.parametrize("target", RUNNING)
@pytest.mark.slow
def test_a_target_has_the_bits_of_the_generated_c(target: str, folder: Path) -> None:
    """`hysgen export MODEL --to TARGET -o DIR --check 1000000` runs it longer."""
    found = compare(model(), target, exported(folder, target), SAMPLES)
    assert {line.target for line in found} == set(exports()[target].ways)
    assert {line.mode for line in found} == {mode.name for mode in MODES}
    assert [line.differ for line in found] == [0] * len(found), "\n".join(map(str, found))


@pytest.mark.proof
@pytest.mark.parametrize("target", RUNNING)
def test_a_target_has_the_bits_of_the_larger_model_that_ships(target: str, tmp_path: Path) -> None:
    shipped = proof_models.shipped("extended").model
    need(*TOOLS.get(target, ()))
    write_export(shipped, target, tmp_path)
    found = compare(shipped, target, tmp_path, 20_000)
    assert [line.differ for line in found] == [0] * len(found), "\n".join(map(str, found))


@pytest.mark.slow
def test_a_wrong_bit_in_a_target_is_seen(folder: Path, tmp_path: Path) -> None:
    """The last bit of a constant in the folder's own C, after the reference was made."""
    here = tmp_path / "shared"
    shutil.copytree(exported(folder, "shared"), here)
    params = here / "model" / f"{NAME}_params.h"
    text = params.read_text()
    constant = re.search(rf"#define {NAME.upper()}_PER_STEP +(\S+)f", text)
    assert constant is not None
    moved = np.nextafter(np.float32(constant[1]), np.float32(1e9))
    params.write_text(text.replace(constant[0], constant[0].replace(constant[1], f"{moved:.9g}")))
    subprocess.run(["make", "-s", "-B", f"lib{NAME}.so"], cwd=here, check=True)
    assert all(line.differ > 0 for line in compare(model(), "shared", here, 200))


def test_the_component_calls_the_functions_of_the_model() -> None:
    """Learn, commit, predict; and each step alone: the same as direct calls, in this order."""
    component = Reference.compile(model(), Options())
    host = Host(NAME, generate(model()))
    for mode in MODES:
        samples = inputs(component, mode, 800)
        expected = direct(host, samples)
        assert np.array_equal(component.run(samples), expected[0])
        if mode.name == "learn":
            assert 1 in expected[1], "no commit was accepted: the order of commit and predict is not tried"


def direct(host: Host, samples: Samples) -> tuple[np.ndarray, list[int]]:
    """(n, 2) results and status words of calls of the model's own functions, and the answers of commit."""
    ours = host.instance(float(samples.y0_um), float(samples.u0_V))
    learner = host.struct(f"{NAME}_learner_t")
    host.call("learn_init", learner, ours)
    out = np.empty((len(samples.rows), 2), np.uint32)
    answers = [1]
    learns = samples.mode.name == "learn"
    committing = False
    for k in range(len(out)):
        y, value, aux = samples.column(0)[k], samples.column(1)[k], samples.aux[k].tolist()
        host.call("aux", ours, aux)
        if learns:
            host.call("learn_aux", learner, aux)
            host.call("learn", learner, y, value)
            if committing or samples.commit[k]:
                answers.append(host.commit(ours, learner))
                committing = answers[-1] in (Commit.BUSY, Commit.TRYING)
        function = "predict" if learns else samples.mode.name
        result = host.call(function, ours, *([value] if function == "simulate" else [y, value]))
        out[k] = np.float32(result).view(np.uint32), ours.status | (learner.status << 16 if learns else 0)
    return out, answers[1:]


def test_the_exports_leave_out_what_the_model_lacks(tmp_path: Path) -> None:
    plain = load_model("appendix_a")
    texts = export_texts(plain, "sfunction", Options(inverse=False))
    assert "COMPONENT_INVERSE" not in texts["appendix_a_component.h"]
    assert "COMPONENT_LEARN" not in texts["appendix_a_component.h"]
    write_export(plain, "shared", tmp_path, Options(inverse=False))
    said: list[tuple[float, str]] = []
    found = compare(plain, "shared", tmp_path, 100, Options(inverse=False), lambda *step: said.append(step))
    assert [line.mode for line in found] == ["predict", "simulate"]
    assert said == [(0.0, "ctypes, mode predict"), (0.5, "ctypes, mode simulate")]
    with pytest.raises(HysgenError, match="arduino: is no target; choose from a2l, cmake"):
        export_texts(plain, "arduino")


def test_texts_are_the_same_on_every_run_and_name_no_place() -> None:
    for target in exports():
        texts = export_texts(model(), target)
        assert digest(repr(texts).encode()) == digest(repr(export_texts(model(), target)).encode())
        assert not any(str(Path.cwd()) in text or "/tmp" in text for text in texts.values())


@pytest.mark.parametrize(
    ("target", "call", "words"),
    [
        ("shared", [sys.executable, "example.py"], "self-test: 0 mismatches"),
        ("fmu", [sys.executable, "example.py"], "fmi3: 0 problems"),
        ("a2l", ["make", "run"], "self-test: 0 mismatches"),
        ("sfunction", ["make", "check", "octave"], "S-function: compiled and started"),
        ("cortexm", ["make", "run"], "self-test: 0 mismatches\npredict: 0 .. 0 cycles: no counter here\n"),
    ],
)
@pytest.mark.slow
def test_the_example_in_the_folder_runs(target: str, call: list[str], words: str, folder: Path) -> None:
    done = subprocess.run(call, cwd=exported(folder, target), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert words in done.stdout + done.stderr


@pytest.mark.slow
def test_a_project_finds_the_installed_cmake_package(folder: Path) -> None:
    here = exported(folder, "cmake")
    prefix = here / "install"
    for call in (
        ["cmake", "-S", ".", "-B", "build", f"-DCMAKE_INSTALL_PREFIX={prefix}"],
        ["cmake", "--build", "build"],
        ["cmake", "--install", "build"],
        ["cmake", "-S", "consumer", "-B", "consumer/build", f"-DCMAKE_PREFIX_PATH={prefix}"],
        ["cmake", "--build", "consumer/build"],
        ["consumer/build/consumer"],
    ):
        done = subprocess.run(call, cwd=here, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_the_verb_writes_checks_and_refuses_by_the_stated_budget(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    call = ["export", "appendix_a", "--to", "shared", "-o", str(tmp_path / "s")]
    assert main([*call, "--check", "500"]) == 0
    assert "ctypes         inverse   500 samples, 0 differ" in capsys.readouterr().out
    assert main([*call, "--clock", "16e6"]) == 0
    assert main([*call, "--clock", "16e6", "--budget", "200"]) == 2
    assert "has 320 at 16 MHz, the budget is 200" in capsys.readouterr().err
    assert main([*call, "--clock", "16e6", "--budget", "200", "--cycles", "predict=90,simulate=90,inverse=110"]) == 0
    assert main([*call, "--cycles", "forecast=1"]) == 2
    assert "forecast: not a function of appendix_a" in capsys.readouterr().err
    with pytest.raises(BudgetError, match="the period of 20 us has 20 at 1 MHz"):
        generate(load_model("appendix_a"), Options(clock_Hz=1e6))


ROOT = Path(__file__).resolve().parents[2]
FILE = "generator/hysgen/export/stream.py"
ADDED = '''
"""A program that steps the component over standard input."""

from hysgen.export.base import Export, Option, output_of, results


def run_stream(model, folder, samples):
    output_of(["cc", "-o", "stream", "-Imodel", "-I.", "run.c", f"{model.name}_component.c",
               f"model/{model.name}.c"], folder)
    program = str((folder / "stream").resolve())
    return results(output_of([program, *samples.start], folder, samples.rows.tobytes()))


def finish(written):
    (written.folder / "GREETING").write_text(written.given["greeting"] + " from {{ name }}")
    return ["GREETING"]


EXPORT = Export(
    "stream", "Stream", {"run.c": "run.c", "{name}.txt": "{{ name }} at {{ Ts_us }} us\\n"},
    readme="Build run.c.\\n", ways={"cc": run_stream},
    options=(Option("greeting", "TEXT", "first line of the file GREETING"),), finish=finish,
)
'''


@pytest.mark.slow
def test_a_new_export_requires_one_file(tmp_path: Path) -> None:
    for folder in ("generator", "templates"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    assert not (tmp_path / FILE).exists()
    (tmp_path / FILE).write_text(ADDED)

    def hysgen(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "hysgen", "export", *words],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(tmp_path / "generator")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "--greeting TEXT" in hysgen("--help")
    said = hysgen("appendix_a", "--to", "stream", "-o", "out", "--greeting", "Hello", "--check", "300")
    assert "cc             inverse   300 samples, 0 differ" in said
    assert (tmp_path / "out" / "appendix_a.txt").read_text() == "appendix_a at 20 us\n"
    assert (tmp_path / "out" / "GREETING").read_text().startswith("Hello")
    readme = (tmp_path / "out" / "README.md").read_text()
    assert readme.startswith("# Stream of model `appendix_a`")
    assert readme.endswith("Build run.c.\n")


@pytest.mark.parametrize("standard", [2, 3])
@pytest.mark.slow
def test_an_fmu_is_valid_and_holds_nothing_of_python(standard: int, folder: Path) -> None:
    here = exported(folder, "fmu")
    library("fmpy")
    from fmpy.validation import validate_fmu

    path = here / f"{NAME}_fmi{standard}.fmu"
    assert validate_fmu(str(path)) == []
    texts = {file.relative_to(here).as_posix(): file.read_text() for file in here.rglob("*.[chx]*") if file.is_file()}
    assert archive(standard, NAME, texts) == path.read_bytes(), "the same sources make the same archive"
    shutil.unpack_archive(path, here / "unpacked" / path.stem, "zip")
    binary = next((here / "unpacked" / path.stem / "binaries").rglob(f"{NAME}.so"))
    content = subprocess.run(["ldd", binary], capture_output=True, text=True, check=True).stdout
    assert set(re.findall(r"^\s+(\S+?)\.so", content, re.M)) <= {"linux-vdso", "libc", "/lib64/ld-linux-x86-64"}
