"""What an export says of a model, field by field, and what its comparison feeds, counts and refuses."""

import dataclasses
import io
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fixtures.exported_folders import NAME, model
from hysgen import export
from hysgen.codegen import Options
from hysgen.errors import BuildError
from hysgen.export import Reference, a2l, base, export_texts, fmu, programs, write_export
from hysgen.export.base import MODES, component_facts
from hysgen.model.file import load_model
from hysgen.model.intervals import Interval
from hysgen.model.structs import Axis, Member, Status


def test_the_variables_of_an_fmu_are_those_of_the_component() -> None:
    options, ours = Options(), model()
    facts = component_facts(ours, options)
    found = {variable.name: variable for variable in fmu.variables(ours, facts)}
    assert [(v.reference, v.index) for v in found.values()] == [(k, k) for k in range(1, len(found) + 1)]
    by_causality = {
        kind: [name for name, variable in found.items() if variable.causality == kind]
        for kind in ("parameter", "input", "output")
    }
    assert by_causality["parameter"] == ["mode", "y0_um", "u0_V"]
    assert by_causality["input"][:4] == ["y_um", "u_V", "y_next_um", "commit"]
    assert len(by_causality["input"]) == 4 + len(facts["channels"])
    bits = [str(flag.name).lower() for flag in Status if ours.responds or flag is not Status.INVERSE_RESIDUAL]
    assert by_causality["output"] == ["y_model_um", "u_command_V", "status", "answer", *bits]
    mode = found["mode"]
    assert (mode.start, mode.low, mode.high, mode.variability, mode.kind) == ("1", "0", "3", "fixed", "word")
    assert mode.about == "0: predict, 1: simulate, 2: inverse, 3: learn"
    for name, variable in found.items():
        floats, parameter = variable.kind == "float", variable.causality == "parameter"
        assert variable.variability == ("fixed" if parameter else "continuous" if floats else "discrete"), name
        assert variable.settable == (variable.causality != "output")
        assert variable.initial == {"parameter": "exact", "input": "", "output": "calculated"}[variable.causality]
        assert variable.type3 == {"float": "Float32", "word": "UInt32", "boolean": "Boolean"}[variable.kind]
        assert (variable.start is None) == (variable.causality == "output")
    assert {found[name].start for name in ("y0_um", "y_um", "y_next_um")} == {facts["rest_um"]}
    assert {found[name].start for name in ("u0_V", "u_V")} == {facts["middle_V"]}
    assert {found[name].unit for name in ("y0_um", "y_um", "y_next_um", "y_model_um")} == {"um"}
    assert {found[name].unit for name in ("u0_V", "u_V", "u_command_V")} == {"V"}
    assert {name: int(found[name].mask.removesuffix("u"), 16) for name in bits} == {
        str(flag.name).lower(): int(flag) for flag in Status if str(flag.name).lower() in bits
    }
    assert {found[name].member for name in bits} == {"status"}
    assert found["commit"].start == "false"
    assert (np.float32(found["y0_um"].c_start.removesuffix("f")), mode.c_start) == (np.float32(facts["rest_um"]), "1u")
    appendix = load_model("appendix_a")
    plain = {variable.name for variable in fmu.variables(appendix, component_facts(appendix, Options(inverse=False)))}
    assert not plain & {"y_next_um", "commit", "answer"}


@pytest.mark.parametrize(
    ("system", "machine", "two", "three"),
    [
        ("linux", "x86_64", (".so", "linux64"), (".so", "x86_64-linux")),
        ("darwin", "arm64", (".dylib", "darwin64"), (".dylib", "aarch64-darwin")),
        ("win32", "AMD64", (".dll", "win64"), (".dll", "x86_64-windows")),
    ],
)
def test_a_binary_lies_where_the_standard_has_its_platform(
    system: str, machine: str, two: tuple[str, str], three: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr("platform.machine", lambda: machine)
    assert (fmu._library(2), fmu._library(3)) == (two, three)


@pytest.mark.parametrize("standard", [2, 3])
def test_an_archive_holds_its_standards_sources_and_no_time(standard: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fmu, "_binary", lambda standard, sources: "\n".join(sources).encode())
    monkeypatch.setattr(fmu, "_library", lambda _: (".so", "here"))
    texts = export_texts(model(), "fmu")
    with zipfile.ZipFile(io.BytesIO(fmu.archive(standard, NAME, texts))) as bundle:
        entries = {entry.filename: entry for entry in bundle.infolist()}
        content = {name: bundle.read(name).decode() for name in entries}
    assert {entry.date_time for entry in entries.values()} == {(1980, 1, 1, 0, 0, 0)}
    assert {entry.compress_type for entry in entries.values()} == {zipfile.ZIP_DEFLATED}
    sources = {f"{NAME}_fmi{standard}.c", f"{NAME}_fmu.c", f"{NAME}_component.c", f"{NAME}.c", *fmu.HEADERS[standard]}
    sources |= {f"{NAME}_params.h", f"{NAME}_fmu.h", f"{NAME}_component.h", f"{NAME}.h"}
    others = {"modelDescription.xml", f"binaries/here/{NAME}.so"}
    others |= {"sources/buildDescription.xml"} if standard == 3 else set()
    assert set(entries) == {f"sources/{name}" for name in sources} | others
    assert content["modelDescription.xml"] == texts[f"modelDescription{standard}.xml"]
    listed = texts["buildDescription3.xml"] if standard == 3 else texts["modelDescription2.xml"]
    for unit in (f"{NAME}_fmi{standard}.c", f"{NAME}_fmu.c", f"{NAME}_component.c", f"{NAME}.c"):
        assert f'name="{unit}"' in listed
    for path, text in texts.items():
        if path.startswith(f"sources{standard}/"):
            assert content[f"sources/{Path(path).name}"] == text


def test_the_identity_of_an_fmu_changes_with_a_name_and_a_text_and_not_with_their_order() -> None:
    token = fmu.token({"a": "1", "b": "2"})
    assert [len(part) for part in token.strip("{}").split("-")] == [8, 4, 4, 4, 12]
    assert (token[0], token[-1], fmu.token({"b": "2", "a": "1"})) == ("{", "}", token)
    assert len({token, fmu.token({"a": "1", "b": "3"}), fmu.token({"a": "1", "c": "2"}), fmu.token({"a": "1"})}) == 4


def test_an_fmu_is_compiled_without_a_change_of_values_and_a_fault_is_one_line() -> None:
    with pytest.raises(BuildError, match=r"f\.c:.*'missing'|f\.c: In function") as fault:
        fmu._binary(2, {"f.c": "int f(void) { return missing; }\n"})
    assert "\n" not in str(fault.value)
    assert (
        fmu._binary(2, {"f.c": '__attribute__((visibility("default"))) int fmi2F(void) { return 1; }\n'})[:4]
        == b"\x7fELF"
    )
    assert {"-ffp-contract=off", "-fvisibility=hidden", "-shared"} <= set(fmu._FLAGS)


# A2L


def test_limits_without_a_proof_are_those_of_the_type_and_others_the_hull_of_all_elements() -> None:
    assert float(np.finfo(np.float32).max) == a2l.LARGEST
    assert float(np.iinfo(np.uint32).max) == a2l.LARGEST_WORD
    limits = a2l.Limits({"a.x[0]": Interval(-1.0, 2.0), "a.x[1]": Interval(0.0, 5.0)}, {"a.n": 7})
    x, n = Member("x", "float", "", (2,)), Member("n", "uint32_t", "")
    assert limits.of("a.", x) == (-1.0, 5.0)
    assert limits.of("b.", x) == (-a2l.LARGEST, a2l.LARGEST)
    assert limits.of("a.", dataclasses.replace(x, sizes=(3,))) == (-a2l.LARGEST, a2l.LARGEST), "an element has none"
    assert (limits.of("a.", n), limits.of("b.", n)) == ((0.0, 7.0), (0.0, a2l.LARGEST_WORD))


@pytest.mark.parametrize(("value", "low", "high"), [(3.0, 0.0, 3.0), (-2.0, -2.0, 1.0), (0.0, 0.0, 1.0)])
def test_a_table_of_one_number_has_limits_that_hold_it_and_differ(value: float, low: float, high: float) -> None:
    given: Any = SimpleNamespace(
        name="t", values=np.full(3, value), type="float", axis=None, about=SimpleNamespace(meaning="m", unit="um/V")
    )
    entry = a2l._table("m", given, a2l.Elf({"m_t": (64, 12)}, True))
    assert entry == a2l.Entry("m_t", "m", "float", "um/V", 64, 3, low, high)
    assert (entry.asap, entry.conversion, entry.axis_conversion) == ("FLOAT32_IEEE", "CM_FLOAT32_IEEE_um_V", "")
    word = dataclasses.replace(entry, type="uint32_t", unit="")
    assert (word.asap, word.conversion) == ("ULONG", "CM_ULONG_none")
    flags = (Status.Y_CLAMPED, Status.UNREACHABLE)
    bits = [(bit.name, bit.about, bit.low, bit.high, bit.mask) for bit in a2l._bits(word, flags)]
    assert bits == [(f"m_t.{flag.name}", flag.meaning, low, 1.0, hex(flag)) for flag in flags]
    axed = dataclasses.replace(entry, axis=Axis("frequency", "Hz", (0.0, 1.0)))
    methods = {(m.name, m.type, m.unit) for m in a2l.Description((axed,), (word,), "MSB_LAST").methods}
    assert methods == {
        ("CM_FLOAT32_IEEE_um_V", "FLOAT32_IEEE", "um/V"),
        ("CM_FLOAT32_IEEE_Hz", "FLOAT32_IEEE", "Hz"),
        ("CM_ULONG_none", "ULONG", ""),
    }


# The comparison


@pytest.mark.parametrize(("mode", "scale"), [(MODES[0], 1.0), (MODES[3], 1.002)], ids=["predict", "learn"])
def test_a_displacement_is_the_free_run_with_little_noise_enlarged_for_a_learner(mode: Any, scale: float) -> None:
    component = Reference.compile(load_model("appendix_a"), Options())
    samples = export.inputs(component, mode, 97)
    rows = dataclasses.replace(samples, mode=export.SIMULATE)
    free = np.concatenate([[samples.y0_um], component.run(rows)[:-1, 0].copy().view(np.float32)])
    noise = samples.column(0) / scale - free
    assert noise.std() == pytest.approx(1e-4, rel=0.2)
    assert abs(noise.mean()) < 4e-5


def test_a_comparison_counts_samples_of_another_result_or_status_and_says_how_far_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    component = Reference.compile(model(), Options())

    def other(places: list[tuple[int, int]]) -> Any:
        def run(_: Any, __: Path, samples: base.Samples) -> Any:
            words = component.run(samples).copy()
            for row, column in places:
                words[row, column] ^= 1
            return words

        return run

    ways = {"equal": other([]), "wrong": other([(0, 0), (3, 1), (7, 0), (7, 1)])}
    monkeypatch.setattr(export, "export_of", lambda _: SimpleNamespace(ways=ways))
    progress: list[tuple[float, str]] = []
    found = export.compare(model(), "shared", tmp_path, 20, None, lambda *step: progress.append(step))
    assert [(line.target, line.mode, line.samples, line.differ) for line in found] == [
        (way, mode.name, 20, differ) for mode in MODES for way, differ in (("equal", 0), ("wrong", 3))
    ]
    assert progress == [
        ((m + r / 2) / 4, f"{way}, mode {mode.name}") for m, mode in enumerate(MODES) for r, way in enumerate(ways)
    ]
    assert str(found[1]) == "wrong          predict   20 samples, 3 differ"
    monkeypatch.setattr(
        export, "export_of", lambda _: SimpleNamespace(ways={"short": lambda *_: np.zeros((19, 2), np.uint32)})
    )
    with pytest.raises(BuildError, match="short, mode predict: 19 of 20 samples came back"):
        export.compare(model(), "shared", tmp_path, 20)
    missing = dataclasses.replace(MODES[0], number=9, name="none")
    with pytest.raises(BuildError, match="has no mode none"):
        component.run(base.Samples(missing, np.float32(0), np.float32(0), np.zeros((1, 4), np.uint32)))


def test_a_tool_that_is_missing_or_fails_is_named_with_its_last_words(tmp_path: Path) -> None:
    assert base.output_of(["sh", "-c", "cat; pwd"], tmp_path, b"in ") == f"in {tmp_path}\n".encode()
    with pytest.raises(BuildError, match="no-such-tool is not installed: this target was not compared"):
        base.output_of(["no-such-tool"], tmp_path)
    with pytest.raises(BuildError, match=r"^sh -c echo a >&2; echo b >&2; echo c; exit 3: b$"):
        base.output_of(["sh", "-c", "echo a >&2; echo b >&2; echo c; exit 3"], tmp_path)
    with pytest.raises(BuildError, match=r"^sh -c exit 3: exit code 3$"):
        base.output_of(["sh", "-c", "exit 3"], tmp_path)
    rows = np.arange(6, dtype=np.uint32)
    assert base.results(rows.tobytes()).tolist() == [[0, 1], [3, 4]]


def test_a_folder_whose_build_fails_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = load_model("appendix_a")
    written = write_export(plain, "shared", tmp_path, Options(inverse=False))
    assert sorted(written) == sorted(path for path in tmp_path.rglob("*") if path.is_file())
    rows = np.zeros((1, 3), np.uint32)
    with pytest.raises(BuildError, match="the shared library has no mode inverse"):
        programs.run_shared(plain, tmp_path, base.Samples(MODES[2], np.float32(0.0), np.float32(0.0), rows))
    (tmp_path / "Makefile").write_text("all:\n\t@echo broken >&2; false\n")
    with pytest.raises(BuildError, match=r"make all: broken$"):
        base.make(tmp_path, "all")
    monkeypatch.setattr(base, "default_toolchain", lambda: SimpleNamespace(call=["mine"]))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BuildError, match="make is not installed; install it"):
        base.make(tmp_path, "all")
