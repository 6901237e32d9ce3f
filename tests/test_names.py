"""No external name of the firmware, of generated code or of a host library can be taken for that of another library."""

import dataclasses
import keyword
import os
import re
import shlex
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest

from fixtures import exported_folders, firmware_bench
from fixtures.foreign_names import COMMON, RUNNER, SELFTEST, aborting, output, preloaded, program, settings, zlib
from fixtures.tools import library, need
from hysgen.checking import Host
from hysgen.codegen import generate
from hysgen.codegen.manifest import c_files
from hysgen.codegen.render import render
from hysgen.errors import FitError, ModelError
from hysgen.export import export_texts, exports, write_export
from hysgen.export.fmu import _binary
from hysgen.firmware import CONTROLLER, HOST_BOARD, Label, encode, firmware_folder, firmware_model, read_sources
from hysgen.firmware.wire import image_frames
from hysgen.fitting import FitSettings
from hysgen.machine import kernels
from hysgen.machine.kernel_build import build_kernels
from hysgen.machine.native import default_toolchain, externals
from hysgen.model.file import load_model
from hysgen.model.names import TAKEN, is_taken
from hysgen_c674x.translation import compiled
from hysgen_lab.firmware.host import HostImage
from hysgen_lab.stage import state
from hysgen_lab.studies.endurance.compiled_learner import CompiledLearner

REQUIRED = {
    "main": "the entry of a C program",
    "_c_int00": "the entry that the C6748's tools and the boot image jump to",
    "memcpy": "gcc copies structs by it; the Cortex-M example has no C library",
    "memset": "gcc clears structs by it; the Cortex-M example has no C library",
    "mexFunction": "the entry of a MEX file",
}
"""External names without prefix, each with the reason."""
STANDARD = re.compile(r"fmi[23][A-Z]\w*")
"""Functions of the FMI standard."""
INLINE = re.compile(r"__asm__(?: volatile)?\s*\((?:[^()]|\([^()]*\))*\)")


def assembly(folder: Path, unit: str, *flags: str) -> str:
    """A C unit in `folder` as the compiler's assembly, without its own, which may be of another processor."""
    text = INLINE.sub("", (folder / unit).read_text(encoding="utf-8"))
    options = "-std=gnu99 -w -fPIC -DMAIN_FILLED_IN -I. -S -xc -"
    with tempfile.NamedTemporaryFile("r", suffix=".s") as made:  # the compiler of pip writes to no pipe
        command = [*default_toolchain().call, *flags, *options.split(), "-o", made.name]
        done = subprocess.run(command, cwd=folder, input=text, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return Path(made.name).read_text(encoding="utf-8")


def external(text: str) -> set[str]:
    """External names of assembly, GNU's or TI's, and of a linker script."""
    names = re.findall(r"^\s*\.(?:globl|global|def|comm)\s+(\w+)", text, re.MULTILINE)
    local = re.findall(r"^\s*\.local\s+(\w+)", text, re.MULTILINE)
    return {*names, *re.findall(r"\b(\w+) = \.(?!\s*[+;]?\s*ALIGN)", text)} - {*local}


def foreign(names: set[str], *prefixes: str) -> set[str]:
    """The names that have no prefix of ours."""
    ours = ("hysgen_", *prefixes)
    return {n for n in names if not n.startswith(ours) and n not in REQUIRED and not STANDARD.fullmatch(n)}


def firmware_names() -> dict[str, set[str]]:
    """External names of every file of the firmware, by its path."""
    root = firmware_folder()
    names = {}
    for path in sorted([*root.glob("controller/*.c"), *root.glob("board/**/*.c")]):
        board = path.parent if path.parent.name not in ("controller", "board") else root / "board" / "simulator"
        include = [root / "controller", board, root / "models" / "extended"]
        names[str(path.relative_to(root))] = external(assembly(path.parent, path.name, *(f"-I{x}" for x in include)))
    for path in sorted([*root.glob("board/*/*.s"), *root.glob("board/*/*.ld")]):
        names[str(path.relative_to(root))] = external(path.read_text(encoding="utf-8"))
    return names


def test_every_external_name_of_the_firmware_has_the_prefix() -> None:
    names = firmware_names()
    assert len(names) > 20
    assert "hysgen_crc32" in names["controller/crc32.c"]
    assert "hysgen_board_voltage" in names["board/c6748/board.c"]
    assert "hysgen_vectors" in names["board/c6748/start.s"]
    assert "hysgen_stack_top" in names["board/c6748/c6748.ld"]
    assert {file: wrong for file, found in names.items() if (wrong := foreign(found))} == {}


def test_a_name_without_prefix_is_seen() -> None:
    assert foreign(external("\t.globl\tcrc32\n\t.comm\ttable,4,4\n\t.globl main\n")) == {"crc32", "table"}
    assert foreign(external("        .def    vectors\n bss : { start_bss = .; *(.bss) }")) == {"vectors", "start_bss"}
    assert foreign({"hysgen_crc32", "fmi2DoStep", "stage_init", "stages"}, "stage_") == {"stages"}


@pytest.mark.slow
def test_every_external_name_of_generated_code_has_a_prefix(tmp_path: Path) -> None:
    """Model, drivers of `verify`, and every unit of every export that compiles here."""
    model = exported_folders.model()
    host = Host(model.name, generate(model))
    facts = {"name": model.name, "NAME": model.name.upper()}
    folders: dict[str, Mapping[str, str]] = {t: export_texts(model, t) for t in exports()}
    folders["drivers"] = {
        **c_files(generate(model)),
        "driver.c": render(
            "driver.c.j2",
            {
                **facts,
                "structs": host.interface.structs,
                "entries": list(host.entries.values()),
                "channels": host.channels,
                "commits": host.commits,
            },
        ),
        "endurance.c": render("endurance.c.j2", facts),
    }
    seen = set()
    for target, texts in folders.items():
        for name, text in texts.items():
            path = tmp_path / target / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        for name in texts:
            if name.endswith(".c") and "_mex.c" not in name:  # MEX needs MATLAB's header
                unit = tmp_path / target / name
                include = (tmp_path / target / folder for folder in (".", "model", "standin"))
                found = external(assembly(unit.parent, unit.name, *(f"-I{path}" for path in include)))
                assert foreign(found, f"{model.name}_") == set(), (target, name)
                seen |= found
    assert {f"{model.name}_predict", "hysgen_driver_learn", "hysgen_endurance_run", "hysgen_reset"} <= seen


def exported_names(library: Path) -> set[str]:
    """Names in the dynamic symbol table of a library; gcc adds `f.resolver` to a function that it compiled twice."""
    nm = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    return {name for line in nm.splitlines() if "." not in (name := line.split()[-1].split("@")[0])}


@pytest.mark.slow
def test_a_host_library_exports_what_is_called_and_nothing_else(tmp_path: Path) -> None:
    model = firmware_bench.model()
    name = model.name
    texts = generate(model)
    host = Host(name, texts)
    public = {f"{name}_{function.name}" for function in host.interface.functions}
    drivers = {"hysgen_driver_flushes", "hysgen_driver_commit", *(f"hysgen_driver_{entry}" for entry in host.entries)}
    called = {f"hysgen_firmware_{f}" for f in ("boot", "interrupt", "idle", "status", "panic")} | {"hysgen_host_run"}
    stage = {"hysteresis_clear", "hysteresis_move", "hysteresis_path", "plant_rest", "plant_run", "plant_step"}
    assert exported_names(firmware_bench.image().library.path) == called
    assert exported_names(host._library.path) == public | drivers
    assert exported_names(CompiledLearner(model)._library.path) == public | {"hysgen_endurance_run"}
    assert exported_names(state.plant().path) == stage
    assert exported_names(compiled({}).path) == {"c674x_run"}
    folder = Path(kernels.__file__).parent
    kernels_called = {n for path in folder.glob("*.py") for n in re.findall(r'"(hysgen_\w+)"', path.read_text("utf-8"))}
    assert exported_names(build_kernels(folder, default_toolchain().command, tmp_path)) == kernels_called


@pytest.mark.slow
def test_an_fmu_exports_the_functions_of_fmi_and_nothing_else(tmp_path: Path) -> None:
    texts = export_texts(exported_folders.model(), "fmu")
    for standard in (2, 3):
        folder = f"sources{standard}/"
        sources = {n.removeprefix(folder): text for n, text in texts.items() if n.startswith(folder)}
        library = tmp_path / f"fmi{standard}.so"
        library.write_bytes(_binary(standard, sources))
        names = exported_names(library)
        assert f"fmi{standard}DoStep" in names
        assert [n for n in sorted(names) if not re.fullmatch(rf"fmi{standard}[A-Z]\w*", n)] == []


def test_the_names_that_declarations_declare_are_read() -> None:
    declared = """
        #define X f(3)
        typedef struct { int (*call)(int); } a_t; typedef int made(int);
        extern a_t *chip; extern uint32_t log[7][2], count;
        /* not(3); */ extern int foo(int a, int b); struct s { struct { int q; } w; };
        const char *one(const uint8_t *x, void (*f)(int));"""
    assert externals(declared) == ["chip", "count", "foo", "log", "one"]


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A parameter image that the firmware takes, as frames: store, CRC and MAC are at work."""
    path = tmp_path_factory.mktemp("frames") / "frames"
    path.write_bytes(b"".join(image_frames(encode(firmware_bench.model(), firmware_bench.KEY, Label(counter=7)))))
    return path


def bare_names() -> set[str]:
    """The firmware's external names as they would be without prefix."""
    return {name.removeprefix("hysgen_") for names in firmware_names().values() for name in names} - set(REQUIRED)


def headers() -> dict[str, str]:
    """Headers of controller, host board and model, and the C of the model's firmware."""
    return {
        **dict([*read_sources(CONTROLLER), *read_sources(HOST_BOARD)]),
        **c_files(firmware_model(firmware_bench.model())),
    }


def run(folder: Path, image: HostImage, frames: Path, foreign_c: str = "", *flags: str) -> str:
    """What the firmware's run prints in a program with `foreign_c` beside it."""
    texts = {name: text for name, text in headers().items() if name.endswith(".h")} | {"settings_here.h": settings()}
    return output(
        program(folder, {**texts, "foreign.c": foreign_c, "runner.c": RUNNER}, *flags), image.library.path, frames
    )


@pytest.mark.slow
def test_among_foreign_functions_of_its_names_the_firmware_computes_the_same(tmp_path: Path, frames: Path) -> None:
    (tmp_path / "alone").mkdir()
    image = firmware_bench.image()
    alone = run(tmp_path / "alone", image, frames)
    assert "image 0 counter 7" in alone
    assert run(tmp_path, image, frames, aborting({*COMMON, *bare_names()})) == alone


def test_beside_zlib_the_firmware_computes_the_same(tmp_path: Path, frames: Path) -> None:
    """zlib's crc32 comes first in a program that links it, as Debian's python3 does."""
    library = zlib()
    (tmp_path / "alone").mkdir()
    image = firmware_bench.image()
    alone = run(tmp_path / "alone", image, frames)
    assert run(tmp_path, image, frames, "", "-Wl,--no-as-needed", f"-l:{library}") == alone


@pytest.mark.slow
def test_the_firmwares_sources_link_with_foreign_functions_of_their_names(tmp_path: Path) -> None:
    own = headers()
    start = "int main(void) { return 0; }\n"
    program(tmp_path, {**own, "foreign.c": aborting({*COMMON, *bare_names()}) + start})


def test_among_foreign_functions_the_verified_library_passes_its_self_test(tmp_path: Path) -> None:
    model = firmware_bench.model()
    texts = {"selftest.c": SELFTEST, "foreign.c": aborting(COMMON)}
    library = Host(model.name, generate(model))._library.path
    assert output(program(tmp_path, texts), library, f"{model.name}_selftest") == "0\n"


IN_PYTHON = {
    "stage": """
import numpy
from hysgen_lab.stage import Stage, run
u_V = 50.0 + 45.0 * numpy.sin(numpy.arange(2000) / 60.0)
print(run(Stage.laboratory(), u_V, 1e-4, 1).displacement_um.tobytes().hex())
""",
    "export": """
import sys, hysgen
from pathlib import Path
from hysgen.export import compare
model = hysgen.load_model("appendix_a")
print([line.differ for line in compare(model, sys.argv[1], Path(sys.argv[2]), 400)])
""",
}
"""Lines of Python that run a host library and print what it computes."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stage", "fmu", "shared"])
def test_among_foreign_functions_of_its_names_a_host_library_computes_the_same(name: str, tmp_path: Path) -> None:
    """The foreign functions are loaded before every library, and have the names of its functions, hidden or not.

    No kernel calls another across C files, so the linker cannot take one for another: what the kernels' library exports
    is tested above.
    """
    script, folder = IN_PYTHON.get(name, IN_PYTHON["export"]), tmp_path / "export"
    if name in exports():
        library("fmpy")
        write_export(load_model("appendix_a"), name, folder)
    if name == "shared":  # an FMU is compiled by its export
        subprocess.run(["make", "-s", f"CC={shlex.join(default_toolchain().call)}"], cwd=folder, check=True)
    for path in folder.glob("*.fmu"):
        zipfile.ZipFile(path).extractall(path.with_suffix(""))

    def printed(**variables: str) -> str:
        here = {"HYSGEN_CACHE": str(tmp_path / "cache"), **variables}
        call = [sys.executable, "-c", script, name, str(folder)]
        done = subprocess.run(call, env={**os.environ, **here}, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    alone = printed()
    names = {n for path in tmp_path.rglob("*.so") for n in functions(path)}
    assert len(names) > 5
    assert printed(LD_PRELOAD=str(preloaded(tmp_path, names))) == alone


def functions(library: Path) -> set[str]:
    """Names of a library's own functions, but those that the linker adds."""
    nm = subprocess.run(["nm", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    names = {name for _, kind, name in map(str.split, nm.splitlines()) if kind in "tTiW" and name.isidentifier()}
    return {name for name in names if name[0] != "_" and not name.endswith(("tm_clones", "frame_dummy"))}


def test_a_name_that_is_taken_is_refused() -> None:
    model = load_model("appendix_a")
    for name in (*TAKEN, "Upper", "with-dash"):
        with pytest.raises(ModelError, match=r"^name: "):
            dataclasses.replace(model, name=name)
    with pytest.raises(FitError, match=r"^name: 'float' is a word"):
        FitSettings(name="float")


HEADERS = """
aio arpa/inet assert complex cpio ctype dirent dlfcn errno fcntl fenv float fmtmsg fnmatch ftw glob grp iconv inttypes
langinfo libgen limits locale math monetary mqueue net/if netdb netinet/in nl_types poll pthread pwd regex sched
search semaphore setjmp signal spawn stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib string strings
sys/ipc sys/mman sys/msg sys/resource sys/select sys/sem sys/shm sys/socket sys/stat sys/statvfs sys/time sys/times
sys/types sys/uio sys/un sys/utsname sys/wait syslog tar termios time uchar unistd utime utmpx wchar wctype wordexp
"""
"""Headers of C and POSIX that C++ can read, too."""


@pytest.mark.parametrize("language", ["c", "c++"])
def test_every_accepted_name_compiles_beside_the_others_the_controller_and_the_system(
    language: str, tmp_path: Path
) -> None:
    """All names at which the system has a type or a header, keywords and plain words; one run of the compiler."""
    need(*(["g++"] if language == "c++" else []))

    def ran(*flags: str, text: str = "") -> subprocess.CompletedProcess[str]:
        call = [*(default_toolchain().call if language == "c" else ["g++"]), "-w", f"-x{language}", *flags]
        return subprocess.run(call, cwd=tmp_path, input=text, capture_output=True, text=True, check=False)

    system = "".join(f"#include <{header}.h>\n" for header in HEADERS.split() if language == "c" or header != "complex")
    seen = ran("-E", "-dD", "-", text=system).stdout
    texts = c_files(generate(dataclasses.replace(load_model("appendix_a"), name="placeholder")))
    parts = "|".join(sorted(set(re.findall(r"\bplaceholder_(\w+)", "".join(texts.values())))))
    controller = read_sources(CONTROLLER, "*.h")
    words = {*TAKEN, *keyword.kwlist, *(Path(file).stem for file, _ in controller)}
    for shown in (rf"\b([a-z]\w*?)_(?:{parts})\b", r"/(\w+)\.h", r"#define ([a-z]\w*) ", r"\b[a-z][a-z0-9]{2,3}\b"):
        words |= set(re.findall(shown, seen))
    accepted = [word for word in sorted(words) if re.fullmatch(r"[a-z]\w*", word) and not is_taken(word)]
    assert len(accepted) > 250
    for name in accepted:
        for file in ("placeholder.h", "placeholder_params.h", "placeholder_selftest.h"):
            own = texts[file].replace("placeholder", name).replace("PLACEHOLDER", name.upper())
            (tmp_path / file.replace("placeholder", name)).write_text(own)
    for file, text in (*controller, *firmware_model(firmware_bench.model()).items()):
        (tmp_path / Path(file).name).write_text(text)
    user = "".join(f'#include "{name}.h"\n#include "{name}_selftest.h"\n' for name in accepted)
    user += "".join(f"int use_{name}(void) {{ {name}_t {name}; return (int)sizeof {name}; }}\n" for name in accepted)
    assert not ran("-I.", "-c", "-o", "user.o", "-", text=f'#include "controller.h"\n{system}{user}').stderr
