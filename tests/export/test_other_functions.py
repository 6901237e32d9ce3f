"""S-function, shared library, program of the CMake package and start-up of the Cortex-M, compiled here and called."""

import functools
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.exported_folders import NAME, model
from hysgen.codegen import Options
from hysgen.codegen.manifest import c_files
from hysgen.export import Reference, export_texts, inputs
from hysgen.export.base import MODES, Mode
from hysgen.float32.struct_words import Commit
from hysgen.machine.native import Library, build, default_toolchain

SAMPLES = 300
CHANNELS = len(model().channels)
SINGLE, WORD = 1, 7
EACH_MODE = pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
CALLS = """
int most_inputs = 8, most_outputs = 8;
void started(SimStruct *S) { mdlInitializeConditions(S); }
void sized(SimStruct *S) { mdlInitializeSizes(S); }
void timed(SimStruct *S) { mdlInitializeSampleTimes(S); }
void put_out(SimStruct *S) { mdlOutputs(S, 0); }
void updated(SimStruct *S) { mdlUpdate(S, 0); mdlTerminate(S); }
"""


@functools.cache
def reference() -> Reference:
    return Reference.compile(model(), Options())


@functools.cache
def texts(target: str) -> dict[str, str]:
    """The C of an export folder by file name, without the example."""
    found = {path.rpartition("/")[2]: text for path, text in export_texts(model(), target).items()}
    return {name: text for name, text in c_files(found).items() if name != "main.c" or target == "cortexm"}


# S-function


@functools.cache
def sfunction() -> Library:
    sources = {name: text for name, text in texts("sfunction").items() if not re.search(r"run\.c|mex\.c|sfun\.c", name)}
    header = sources["simstruc.h"]
    types = header[header.index("typedef int int_T") : header.index("#define mxGetScalar")]
    types = re.sub(r"#define STANDIN_PORTS 8", "", types).replace("STANDIN_PORTS", "8")
    # Simulink has no port where it has no memory.
    for side in ("inputs", "outputs"):
        header = header.replace(f"(((S)->{side} = (n)) <= STANDIN_PORTS)", f"(((S)->{side} = (n)) <= most_{side})")
    sources["simstruc.h"] = header + "extern int most_inputs, most_outputs;\n"
    types += "extern int most_inputs, most_outputs;\n"
    sources["calls.c"] = texts("sfunction")[f"{NAME}_sfun.c"] + CALLS
    return build(list(sources.items()), types + re.sub(r"\{.*\}", ";", CALLS))


def simulink(*parameters: float) -> Any:
    """The S-function with its ports, sized and timed."""
    S = sfunction().ffi.new("SimStruct *")
    S.parameters = len(parameters)
    for i, value in enumerate(parameters):
        S.parameter[i].value = value
    sfunction().lib.sized(S)
    sfunction().lib.timed(S)
    return S


@EACH_MODE
def test_ports_of_the_s_function_are_those_of_its_mode(mode: Mode) -> None:
    S, learns = simulink(mode.number, 1.0, 30.0), mode.name == "learn"
    widths = [*([1] if mode.name != "simulate" else []), 1, CHANNELS, *([1] if learns else [])]
    ports = [getattr(S, "in")[i] for i in range(S.inputs)]
    assert [port.width for port in ports] == widths
    assert [port.type for port in ports] == [SINGLE] * (len(widths) - learns) + [WORD] * learns
    assert all(port.contiguous == port.feedthrough == 1 for port in ports)
    assert [(S.out[i].width, S.out[i].type) for i in range(S.outputs)] == [(1, SINGLE), (1, WORD), (1, WORD)][
        : 2 + learns
    ]
    words = sfunction_words()
    assert [(S.dwork[i].width, S.dwork[i].type) for i in range(S.dworks)] == [(words, WORD)] * 2
    assert (S.sample_time, S.offset, S.parameters_expected, S.error) == (model().Ts_s, 0.0, 3, sfunction().ffi.NULL)


def sfunction_words() -> int:
    return int(getattr(shared().lib, f"{NAME}_shared_bytes")()) // 4


def test_the_s_function_refuses_other_modes_and_waits_for_its_parameters() -> None:
    S = simulink(len(MODES), 1.0, 30.0)
    known = ", ".join(f"{mode.number} ({mode.name})" for mode in MODES)
    assert sfunction().ffi.string(S.error).decode() == f"{NAME}: the model has the modes {known}"
    for few in ((), (1.0, 1.0), (1.0, 1.0, 30.0, 2.0)):
        S = simulink(*few)
        assert (S.parameters_expected, S.inputs, S.outputs, S.dworks) == (3, 0, 0, 0)


def test_the_s_function_sets_up_nothing_more_where_simulink_refuses_its_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sfunction().lib, "most_outputs", 0)
    S = simulink(1, 1.0, 30.0)
    assert (getattr(S, "in")[0].width, S.out[0].width, S.dworks) == (1, 0, 0)
    monkeypatch.setattr(sfunction().lib, "most_inputs", 0)
    S = simulink(1, 1.0, 30.0)
    assert (getattr(S, "in")[0].width, S.outputs, S.dworks) == (0, 0, 0)


@EACH_MODE
def test_the_s_function_has_the_bits_of_the_component_however_often_it_is_asked(mode: Mode) -> None:
    samples, ffi, lib = inputs(reference(), mode, SAMPLES), sfunction().ffi, sfunction().lib
    S = simulink(mode.number, float(samples.y0_um), float(samples.u0_V))
    memory = []
    for ports, count in ((getattr(S, "in"), S.inputs), (S.out, S.outputs), (S.dwork, S.dworks)):
        for i in range(count):
            memory.append(ffi.new("uint32_t []", ports[i].width))
            ports[i].signal = memory[-1]
    lib.started(S)
    answers: set[int] = set()
    out = np.empty((SAMPLES, 2), np.uint32)
    for k, row in enumerate(samples.rows.tolist()):
        given = row if mode.name == "learn" else row[:-1]
        given = given[1:] if mode.name == "simulate" else given
        flat = iter(given)
        for port in memory[: S.inputs]:
            for i in range(len(port)):
                port[i] = next(flat)
        for _ in range(1 + k % 3):
            lib.put_out(S)
        out[k] = memory[S.inputs][0], memory[S.inputs + 1][0]
        answers |= {memory[S.inputs + 2][0]} if mode.name == "learn" else set()
        lib.updated(S)
    assert np.array_equal(out, reference().run(samples))
    assert answers >= {0, 1} or mode.name != "learn"


# Shared library


@functools.cache
def shared() -> Library:
    declared = (
        f"int32_t {NAME}_shared_bytes(void); int32_t {NAME}_shared_selftest(void);\n"
        f"int32_t {NAME}_shared_start(void *, int32_t, int32_t, float, float);\n"
        f"int32_t {NAME}_shared_run(void *, int32_t, const float *, const float *, const float *, const uint32_t *,"
        " float *, uint32_t *);\n"
    )
    return build(list(texts("shared").items()), declared)


def test_the_shared_library_refuses_what_it_cannot_start_and_computes_the_bits() -> None:
    ffi = shared().ffi
    size, selftest, start, run = (
        getattr(shared().lib, f"{NAME}_shared_{name}") for name in ("bytes", "selftest", "start", "run")
    )
    assert selftest() == 0
    memory = ffi.new("uint32_t []", size() // 4)
    assert start(ffi.NULL, size(), 1, 1.0, 30.0) == 1
    assert start(memory, size() - 1, 1, 1.0, 30.0) == 1
    assert start(memory, size(), len(MODES), 1.0, 30.0) == 2
    for mode in MODES:
        samples = inputs(reference(), mode, SAMPLES)
        assert start(memory, size(), mode.number, samples.y0_um, samples.u0_V) == 0
        out = np.zeros((2, SAMPLES), np.uint32)
        floats = [ffi.from_buffer("float *", column) for column in (samples.column(0), samples.column(1), samples.aux)]
        commit, result = ffi.from_buffer("uint32_t *", samples.commit), ffi.cast("float *", ffi.from_buffer(out[0]))
        assert run(memory, -1, *floats, commit, result, ffi.NULL) == 0
        assert not out.any()
        answer = run(memory, SAMPLES, *floats, commit, result, ffi.from_buffer("uint32_t *", out[1]))
        assert np.array_equal(out.T, reference().run(samples))
        assert answer == 0
        if mode.name == "learn":
            answers = [run(memory, 40, *floats, ffi.NULL, result, ffi.NULL) for _ in range(2)]
            assert answers == [Commit.TRYING, Commit.COMMITTED], "the last commit goes on to its end"
        else:
            start(memory, size(), mode.number, samples.y0_um, samples.u0_V)
            again = out.copy()
            assert run(memory, SAMPLES, *floats, ffi.NULL, result, ffi.NULL) == 0
            assert np.array_equal(out, again)


# Program of the CMake package


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("program")
    for name, text in texts("cmake").items():
        (folder / name).write_text(text)
    units = [name for name in texts("cmake") if name.endswith(".c")]
    subprocess.run([*default_toolchain().call, "-O2", "-ffp-contract=off", "-o", "run", *units], cwd=folder, check=True)
    return folder / "run"


@EACH_MODE
def test_the_program_has_the_bits_of_the_component(mode: Mode, program: Path) -> None:
    samples = inputs(reference(), mode, SAMPLES)
    call = [program, str(mode.number), repr(float(samples.y0_um)), repr(float(samples.u0_V))]
    done = subprocess.run(call, input=samples.rows.tobytes() + b"cut", capture_output=True, check=True).stdout
    out = np.frombuffer(done, np.uint32).reshape(-1, 3)
    assert np.array_equal(out[:, :2], reference().run(samples))
    answers = set(out[:, 2].tolist())
    assert answers >= {0, 1} if mode.name == "learn" else answers == {0}
    for wrong in (call[:3], [*call, "1"], [program, str(len(MODES)), *call[2:]]):
        assert subprocess.run(wrong, input=b"", capture_output=True, check=False).returncode == 2


# Start-up of the Cortex-M


def test_the_cortex_m_starts_with_its_data_copied_its_memory_zero_and_its_fpu_on() -> None:
    start = texts("cortexm")["start.c"]
    start = re.sub(
        r"register (.*?) __asm__\(.*?\) = ", r"\1 = ", re.sub(r"__asm__ volatile\(.*?\);", "leave();", start)
    )
    start = start.replace("*(volatile uint32_t *)0xe000ed88u", "cpacr").replace("stack_top[]", "stack_top[1]")
    start = re.sub(r"\b(main|memcpy|memset)\b", r"cortexm_\1", start)
    start = re.sub(r'"r".*?;', "", start)
    moved = "uint32_t ram[12], rom[6], cpacr, calls;\n"
    places = {"data_load": "rom", "data_start": "(ram + 1)", "data_end": "(ram + 5)"}
    places |= {"bss_start": "(ram + 6)", "bss_end": "(ram + 10)"}
    start = re.sub(r"extern uint32_t (data|bss)_\w+\[\];\n", "", start)
    for name, place in places.items():
        start = re.sub(rf"\b{name}\b", place, start)
    code = (
        "#include <setjmp.h>\n#include <stdint.h>\n" + moved + "static jmp_buf back;\nuint32_t stack_top[1];\n"
        "static void leave(void) { ++calls; }\n"
        + start.replace("extern uint32_t stack_top[1];", "")
        + "int cortexm_main(void) { longjmp(back, 1); }\n"
        "int reset(void) { if (setjmp(back) == 0) { hysgen_reset(); } return vectors[1] == hysgen_reset; }\n"
    )
    declared = "extern uint32_t ram[12], rom[6], cpacr, calls; int reset(void);\n"
    declared += "void *cortexm_memcpy(void *, const void *, uint32_t); void *cortexm_memset(void *, int, uint32_t);"
    built = build([("start.c", code)], declared)
    for i in range(12):
        built.lib.ram[i] = 0xA5A5A5A5
    for i in range(6):
        built.lib.rom[i] = 100 + i
    built.lib.cpacr = 0x0F
    assert built.lib.reset() == 1
    kept = 0xA5A5A5A5
    assert list(built.lib.ram) == [kept, 100, 101, 102, 103, kept, 0, 0, 0, 0, kept, kept]
    assert (built.lib.cpacr, built.lib.calls) == (0x00F0000F, 1)
    to = built.ffi.new("uint8_t [5]", [9] * 5)
    assert built.lib.cortexm_memcpy(to, b"abc", 3) == to
    assert bytes(to) == b"abc\x09\x09"
    assert built.lib.cortexm_memset(to + 1, 0x107, 2) == to + 1
    assert bytes(to) == b"a\x07\x07\x09\x09"
