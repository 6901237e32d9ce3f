"""Exports: every target computes the bits of the generated C, and its folder works as it is."""

from __future__ import annotations

import dataclasses
import functools
import os
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures import proof_models
from fixtures.tools import need
from hysgen import export as exporting
from hysgen.checking.host import Host
from hysgen.checking.proof.eva.banks import state_box
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.errors import BudgetError, BuildError, HysgenError
from hysgen.export import TARGETS, A2lSource, export_texts, write_export
from hysgen.export.a2l import read_elf
from hysgen.export.check import RUNNERS, Reference, Samples, compare, inputs, run_fmu
from hysgen.export.component import MODES
from hysgen.export.fmu import archive
from hysgen.machine.files import digest
from hysgen.model.file import dump_model, load_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model

SAMPLES = 2500
TOOLS = {"sfunction": ("make", "octave-cli"), "cortexm": ("arm-none-eabi-gcc", "qemu-system-arm"), "cmake": ("cmake",)}
NAME = "small_everything"
"""Two rules behind every block of the path, with every term, an auxiliary channel and a learner."""


def need_package(name: str) -> Any:
    """A Python package that a target needs; skip, loudly, without it, and fail where tools are required."""
    if os.environ.get("HYSGEN_REQUIRE_TOOLS"):
        return __import__(name)
    return pytest.importorskip(name)


@pytest.fixture(autouse=True)
def _generated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Generate the C of a model once per process: most of the time of an export."""
    monkeypatch.setattr(exporting, "generate", lambda model, options=None: dict(_generated(_Key(model, options))))


class _Key:
    """A model and options as the key of a cache: their text."""

    def __init__(self, model: Model, options: Options | None) -> None:
        self.model, self.options = model, options or Options()
        self.text = dump_model(model) + repr(self.options)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)


@functools.cache
def _generated(key: _Key) -> dict[str, str]:
    return generate(key.model, key.options)


@functools.cache
def model() -> Model:
    learner = LearnerSettings(learned=("gain",), mature=64, noise_um=1e-4)
    return dataclasses.replace(proof_models.model(NAME), learner=learner)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("export")


def exported(folder: Path, target: str) -> Path:
    """The folder of a target, written by the first test that asks for it."""
    for tool in TOOLS.get(target, ()):
        need(tool)
    if target == "fmu":
        need_package("fmpy")
    if not (folder / target).exists():
        write_export(model(), target, folder / target)
    return folder / target


@pytest.mark.parametrize("target", RUNNERS)
@pytest.mark.slow
def test_a_target_has_the_bits_of_the_generated_c(target: str, folder: Path) -> None:
    """`hysgen export MODEL --to TARGET -o DIR --check 1000000` runs it longer."""
    found = compare(model(), target, exported(folder, target), SAMPLES)
    assert {line.target for line in found} == set(RUNNERS[target])
    assert {line.mode for line in found} == {mode.name for mode in MODES}
    assert [line.differ for line in found] == [0] * len(found), "\n".join(map(str, found))


@pytest.mark.proof
@pytest.mark.parametrize("target", RUNNERS)
@pytest.mark.parametrize("name", ["appendix_a", "extended"])
def test_a_target_has_the_bits_of_the_shipped_models(name: str, target: str, tmp_path: Path) -> None:
    shipped = proof_models.shipped(name).model
    for tool in TOOLS.get(target, ()):
        need(tool)
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
                committing = answers[-1] == 0
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
    assert [line.mode for line in compare(plain, "shared", tmp_path, 100, Options(inverse=False))] == [
        "predict",
        "simulate",
    ]
    with pytest.raises(HysgenError, match="not a target of export; choose sfunction, fmu"):
        export_texts(plain, "arduino")


def test_texts_are_the_same_on_every_run_and_name_no_place() -> None:
    for target in TARGETS:
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
        ("cortexm", ["make", "run"], "self-test: 0 mismatches"),
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


@pytest.mark.parametrize("standard", [2, 3])
def test_an_fmu_is_valid_and_holds_nothing_of_python(standard: int, folder: Path) -> None:
    here = exported(folder, "fmu")
    need_package("fmpy")
    from fmpy.validation import validate_fmu

    path = here / f"{NAME}_fmi{standard}.fmu"
    assert validate_fmu(str(path)) == []
    texts = {file.relative_to(here).as_posix(): file.read_text() for file in here.rglob("*.[chx]*") if file.is_file()}
    assert archive(standard, NAME, texts) == path.read_bytes(), "the same sources make the same archive"
    content = subprocess.run(["ldd", _binary(path, here)], capture_output=True, text=True, check=True).stdout
    assert set(re.findall(r"^\s+(\S+?)\.so", content, re.M)) <= {"linux-vdso", "libc", "/lib64/ld-linux-x86-64"}


def _binary(path: Path, here: Path) -> str:
    """The path of the shared library of an FMU, unpacked."""
    target = here / "unpacked" / path.stem
    shutil.unpack_archive(path, target, "zip")
    return str(next((target / "binaries").rglob(f"{NAME}.so")))


@pytest.mark.parametrize("standard", [2, 3])
def test_an_fmu_saves_restores_and_resets_its_state(standard: int, folder: Path) -> None:
    """The same samples after a restore of the state in memory, of its bytes, and after a reset."""
    path = exported(folder, "fmu")
    need_package("fmpy")
    fmu, names = opened(standard, path)
    first = stepped(standard, fmu, names, 50)
    state = (fmu.getFMUstate if standard == 2 else fmu.getFMUState)()
    data = (fmu.serializeFMUstate if standard == 2 else fmu.serializeFMUState)(state)
    ahead = stepped(standard, fmu, names, 50)
    assert not np.array_equal(ahead, first)
    (fmu.setFMUstate if standard == 2 else fmu.setFMUState)(state)
    assert np.array_equal(stepped(standard, fmu, names, 50), ahead)
    back = (fmu.deSerializeFMUstate if standard == 2 else fmu.deserializeFMUState)(data)
    (fmu.setFMUstate if standard == 2 else fmu.setFMUState)(back)
    assert np.array_equal(stepped(standard, fmu, names, 50), ahead)
    fmu.reset()
    begun(standard, fmu, names)
    assert np.array_equal(stepped(standard, fmu, names, 50), first)
    with pytest.raises(Exception, match="DoStep"):
        fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=1.5 * model().Ts_s)
    fmu.terminate()
    fmu.freeInstance()


def test_a_status_bit_of_the_fmu_is_an_event(folder: Path) -> None:
    """FMI 3.0: a step of 100 samples ends early where the voltage leaves its range; outputs follow in event mode."""
    path = exported(folder, "fmu")
    need_package("fmpy")
    fmu, names = opened(3, path, events=True)
    fmu.enterStepMode()
    quiet = fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=100 * model().Ts_s)
    assert quiet[0] in (0, False)
    before = fmu.getUInt32([names["status"]])[0]
    fmu.setFloat32([names["u_V"]], [1e6])
    event, _, early, last = fmu.doStep(
        currentCommunicationPoint=100 * model().Ts_s, communicationStepSize=100 * model().Ts_s
    )
    assert (bool(event), bool(early)) == (True, True)
    assert last == pytest.approx(101 * model().Ts_s)
    assert fmu.getUInt32([names["status"]])[0] == before
    fmu.enterEventMode()
    assert fmu.getBoolean([names["u_clamped"]])[0]
    fmu.terminate()
    fmu.freeInstance()


def opened(standard: int, path: Path, *, events: bool = False) -> tuple[Any, dict[str, int]]:
    """An instance of the FMU in mode simulate, initialised, and the references of its variables."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    file = str(path / f"{NAME}_fmi{standard}.fmu")
    description = fmpy.read_model_description(file)
    names = {variable.name: variable.valueReference for variable in description.modelVariables}
    kind = FMU2Slave if standard == 2 else FMU3Slave
    fmu = kind(guid=description.guid, unzipDirectory=fmpy.extract(file), modelIdentifier=NAME, instanceName="test")
    fmu.instantiate(**({"eventModeUsed": True, "earlyReturnAllowed": True} if events else {}))
    begun(standard, fmu, names)
    return fmu, names


def begun(standard: int, fmu: Any, names: dict[str, int]) -> None:
    if standard == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()


def stepped(standard: int, fmu: Any, names: dict[str, int], n: int) -> np.ndarray:
    """Outputs of n steps under a ramp of the voltage that starts anew with every call."""
    set_float, get_float = (fmu.setReal, fmu.getReal) if standard == 2 else (fmu.setFloat32, fmu.getFloat32)
    out = []
    for k in range(n):
        set_float([names["u_V"]], [30.0 + 0.2 * k])
        fmu.doStep(currentCommunicationPoint=k * model().Ts_s, communicationStepSize=model().Ts_s)
        out.append(get_float([names["y_model_um"]])[0])
    return np.array(out)


def test_a2l_reads_back_with_every_word_unit_and_address(folder: Path) -> None:
    """Read by pya2l. Every word of a struct has one entry; a table at its address holds the model's numbers."""
    need_package("pya2l")
    from pya2l.parser import A2lParser

    here = exported(folder, "a2l")
    with A2lParser() as parser:
        module = parser.tree_from_a2l((here / f"{NAME}.a2l").read_bytes()).PROJECT.MODULE[0]
    elf = read_elf(here / f"{NAME}.elf")
    words: dict[int, str] = {}
    for kind in (module.CHARACTERISTIC, module.MEASUREMENT):
        for entry in kind:
            if entry.HasField("BIT_MASK"):
                continue
            address = entry.ECU_ADDRESS.Address.Value if kind is module.MEASUREMENT else entry.Address.Value
            count = 1
            if entry.HasField("MATRIX_DIM"):
                count = entry.MATRIX_DIM.XDim.Value
            elif kind is module.CHARACTERISTIC and entry.AXIS_DESCR:
                count = entry.AXIS_DESCR[0].MaxAxisPoints.Value
            for word in range(count):
                assert address + 4 * word not in words
                words[address + 4 * word] = entry.Name.Value
            assert entry.LowerLimit.Value < entry.UpperLimit.Value
    for variable in ("instance", "learner"):
        start, size = elf.symbols[f"{NAME}_{variable}"]
        assert all(words[start + at].startswith(f"{NAME}_{variable}.") for at in range(0, size, 4))
    units = {method.Name.Value: method.Unit.Value for method in module.COMPU_METHOD}
    measured = {entry.Name.Value: entry for entry in module.MEASUREMENT}
    assert units[measured[f"{NAME}_instance.y_um"].Conversion.Value] == "um"
    assert units[measured[f"{NAME}_instance.u_V"].Conversion.Value] == "V"
    assert measured[f"{NAME}_instance.status.U_CLAMPED"].BIT_MASK.Mask.Value == 2
    box = state_box(model())["y_um"]
    limits = measured[f"{NAME}_instance.y_um"]
    assert (limits.LowerLimit.Value, limits.UpperLimit.Value) == pytest.approx((box.low, box.high)), "of any commit"
    assert units[measured[f"{NAME}_instance.inputs.creep.high"].Conversion.Value] == "um", "behind the hysteresis"
    assert measured[f"{NAME}_learner.fresh"].UpperLimit.Value == 1, "a flag"
    assert measured[f"{NAME}_learner.theta"].UpperLimit.Value < 1e30, "the limit of a parameter"
    written = {entry.Name.Value: entry for entry in module.CHARACTERISTIC}
    assert units[written[f"{NAME}_delay_part"].Conversion.Value] == "samples"
    assert units[written[f"{NAME}_drift_limit"].Conversion.Value] == "um"
    bank = written[f"{NAME}_instance.bank[1].gain"]
    assert (units[bank.Conversion.Value], bank.AXIS_DESCR[0].MaxAxisPoints.Value) == ("um/um", 2)
    assert not bank.HasField("READ_ONLY")
    assert written[f"{NAME}_gain"].HasField("READ_ONLY")
    centres = next(entry for entry in module.CHARACTERISTIC if entry.Name.Value == f"{NAME}_strength").AXIS_DESCR[0]
    assert [point.Value for point in centres.FIX_AXIS_PAR_LIST.AxisPtsValue] == pytest.approx(model().grid.centres_um)
    assert table(here / f"{NAME}.elf", elf.symbols[f"{NAME}_strength"]) == table_of(here, "strength")


def table(path: Path, symbol: tuple[int, int]) -> tuple[int, ...]:
    """The words of a symbol in the file of an ELF."""
    from elftools.elf.elffile import ELFFile

    with path.open("rb") as stream:
        for segment in ELFFile(stream).iter_segments("PT_LOAD"):
            offset = symbol[0] - segment["p_vaddr"]
            if 0 <= offset < segment["p_filesz"]:
                return struct.unpack(f"<{symbol[1] // 4}I", segment.data()[offset : offset + symbol[1]])
    raise AssertionError("the symbol lies in no segment")


def table_of(here: Path, name: str) -> tuple[int, ...]:
    """The words of a table in the text of <name>_params.h."""
    text = (here / "model" / f"{NAME}_params.h").read_text()
    body = text.partition(f"{NAME}_{name}[")[2].partition("};")[0]
    numbers = re.findall(r"(-?[\d.]+(?:e[-+]\d+)?)f,", body)
    return tuple(struct.unpack("<I", struct.pack("<f", float(number)))[0] for number in numbers)


def test_an_elf_that_does_not_fit_is_refused(folder: Path, tmp_path: Path) -> None:
    elf = exported(folder, "a2l") / f"{NAME}.elf"
    with pytest.raises(BuildError, match="no such variable; name it with --instance"):
        write_export(model(), "a2l", tmp_path, source=A2lSource(elf, "other"))
    with pytest.raises(BuildError, match=r"has \d+ bytes in the ELF, \d+ in the model"):
        write_export(model(), "a2l", tmp_path, source=A2lSource(elf, f"{NAME}_learner"))
    (tmp_path / "text").write_text("no ELF")
    with pytest.raises(BuildError, match="is no ELF file"):
        write_export(model(), "a2l", tmp_path, source=A2lSource(tmp_path / "text"))


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


def test_the_comparison_sees_a_missing_fmu(folder: Path, tmp_path: Path) -> None:
    exported(folder, "fmu")
    with pytest.raises(HysgenError, match="is missing; this is not a folder"):
        run_fmu(2, model(), tmp_path, inputs(Reference.compile(model(), Options()), MODES[0], 10))
