"""Builds, caches, helpers and numbers of the host computer, by what their texts promise."""

import math
import multiprocessing
import os
import subprocess
import sys
import tempfile
import threading
from decimal import Decimal, localcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hysgen.errors import BuildError, HysgenError
from hysgen.machine import files, kernel_build, native, processes, reproducible
from hysgen.machine.cache import LruCache
from hysgen.machine.files import unsealed
from hysgen.machine.native import Toolchain, build, cached_object

# Builds


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_a_product_and_a_sum_are_rounded_apart_at_the_highest_level(cache: Path) -> None:
    """Fused they would give a residue of the product; reassociated, another sum."""
    source = "double f(double a, double b, double c) { return a * b + c; }\n"
    source += "double g(const double *x, int n) { double s = 0.0; for (int i = 0; i < n; i++) s += x[i]; return s; }\n"
    flags = ("-O3", "-march=native")
    library = build(
        [("f.c", source)],
        "double f(double, double, double); double g(double *, int);",
        Toolchain(native.default_toolchain().command, flags),
    )
    a = 1.0 + 2.0**-30
    assert library.lib.f(a, a, -(a * a)) == 0.0
    numbers = np.random.default_rng(1).normal(size=999) * 10.0 ** np.arange(999) ** 0.5
    assert library.lib.g(library.ffi.from_buffer("double *", numbers), 999) == sum(numbers.tolist())
    assert kernel_build.OPTIMISATION == ("-O3",)


def test_an_object_is_compiled_again_for_its_own_headers_only_and_leaves_no_litter(cache: Path) -> None:
    made: list[str] = []

    def object_of(unit: str, texts: dict[str, str], recipe: tuple[str, ...] = ("cc",)) -> Path:
        def compile_to(path: Path) -> None:
            made.append(unit)
            path.write_bytes(unit.encode())

        return cached_object(unit, texts, recipe, compile_to)

    texts = {
        "a.c": '#include "a.h"\n',
        "a.h": '  #  include <b.h>\n#include "a.h"',
        "b.h": "",
        "other.h": "",
        "b.c": "",
    }
    first = object_of("a.c", texts)
    assert object_of("a.c", texts | {"other.h": "changed"}) == first
    assert (made, first.suffix, unsealed(first), len(first.stem)) == (["a.c"], ".o", b"a.c", 32)
    changed = [{"b.h": "x"}, {"a.h": "x"}, {"a.c": texts["a.c"] + "x"}]
    paths = {object_of("a.c", texts | change) for change in changed}
    paths |= {object_of("a.c", texts, ("cc", "-O3")), object_of("b.c", texts | {"b.c": texts["a.c"]})}
    assert len(paths | {first}) == 6
    assert {path.name for path in cache.iterdir()} == {path.name for path in paths | {first}}


def test_a_linker_error_without_the_word_is_told_too(cache: Path, tmp_path: Path) -> None:
    compiler = tmp_path / "cc"
    text = "import sys\nif '--version' in sys.argv: print('mine 7\\nmore')\nelse: sys.exit(300 * 'x')\n"
    compiler.write_text(f"#!{sys.executable}\n{text}")
    compiler.chmod(0o755)
    assert native.compiler_version(str(compiler)) == "mine 7"
    with pytest.raises(BuildError, match=rf"^{compiler} .*-fno-fast-math -O7: x{{200}}$"):
        build([("f.c", "")], "", Toolchain(str(compiler), ("-O7",)))
    assert [path for path in cache.iterdir() if path.suffix in (".so", ".o")] == []
    assert str(Toolchain("gcc", ("-O1", "-g"))) == "gcc -O1 -g"


def test_the_compiler_is_CC_or_the_first_of_the_system_or_that_of_pip(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def install(name: str) -> None:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
        (tmp_path / name).chmod(0o755)

    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(kernel_build.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setenv("CC", "missing")
    with pytest.raises(BuildError, match=r"^no C compiler found: install gcc or clang, .*hysgen\[compiler\]"):
        native.default_toolchain()
    package = SimpleNamespace(submodule_search_locations=[str(tmp_path / "ziglang")])
    monkeypatch.setattr(kernel_build.importlib.util, "find_spec", {"ziglang": package}.get)
    assert kernel_build.find_compiler() is None  # a package without its program
    install("ziglang/zig")
    assert kernel_build.compiler_call("cc")[:2] == [str(tmp_path / "ziglang" / "zig"), "cc"]
    for name in reversed(kernel_build.SYSTEM):
        install(name)
        assert (kernel_build.find_compiler(), kernel_build.compiler_call("cc")) == ("cc", [name])
    install("mine")
    for chosen in ("mine", "mine -m32"):
        monkeypatch.setenv("CC", chosen)
        assert kernel_build.compiler_call(kernel_build.find_compiler() or "") == chosen.split()
    assert kernel_build.compiler_call("tcc") == kernel_build.compiler_call("") == []


def test_the_kernels_library_is_named_by_sources_and_flags_and_built_for_the_processor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.c").write_text("int hysgen_f(void) { return N; }\n")
    (tmp_path / "a.h").write_text("")
    first = kernel_build.library_name(tmp_path)
    monkeypatch.setenv("ARCHFLAGS", "-DN=7 -g")
    library = kernel_build.build_kernels(tmp_path, native.default_toolchain().command, tmp_path / "new" / "folder")
    assert library == tmp_path / "new" / "folder" / first
    from cffi import FFI

    ffi = FFI()
    ffi.cdef("int hysgen_f(void);")
    assert ffi.dlopen(str(library)).hysgen_f() == 7
    (tmp_path / "a.h").write_text("/* changed */")
    assert kernel_build.library_name(tmp_path) != first
    assert (len(first), first[:8], first[-3:]) == (43, "kernels-", ".so")


def test_the_cache_lies_in_the_users_folders_and_a_trial_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    native._usable.cache_clear()
    monkeypatch.delenv("HYSGEN_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "x"))
    assert native.cache_folder() == tmp_path / "x" / "hysgen"
    assert (tmp_path / "x" / "hysgen").stat().st_mode & 0o777 == 0o700
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert native.cache_folder() == tmp_path / ".cache" / "hysgen"
    assert list((tmp_path / ".cache" / "hysgen").iterdir()) == []
    # Another user's folder among the temporary files, or a link there, is not used.
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "real").mkdir(mode=0o700)
    (tmp_path / "link").symlink_to(tmp_path / "real")
    assert native._usable(tmp_path / "real") == tmp_path / "real"
    assert native._usable(tmp_path / "link") is None
    native._usable.cache_clear()
    monkeypatch.setattr(os, "getuid", lambda: 12_345)
    assert native._usable(tmp_path / "real") is None
    native._usable.cache_clear()


def test_a_data_folder_of_a_wheel_comes_before_that_of_a_checkout(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "generator" / "hysgen"
    inside, beside = package / "data", tmp_path / "data"
    for folder in (inside, beside):
        folder.mkdir(parents=True)
    monkeypatch.setattr(files.resources, "files", lambda _: package)
    with pytest.raises(BuildError, match="the folder data is missing; install hysgen again"):
        files.data_folder("data", holds="mark")
    (beside / "mark").touch()
    assert files.data_folder("data", holds="mark") == beside
    (inside / "mark").touch()
    assert files.data_folder("data", holds="mark") == inside


# Memory, threads, processes


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not enforce a limit of the address space")
def test_room_is_what_the_limit_leaves_and_nothing_of_it_is_taken() -> None:
    code = (
        "import resource; from hysgen.errors import HysgenError; from hysgen.machine.processes import *\n"
        "used = int(open('/proc/self/statm').read().split()[0]) * 4096\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + 200 * 2**20,) * 2)\n"
        "print([has_room(size * 2**20) for size in (190, 210, 190)])\n"
        "try: require_room(210 * 2**20)\n"
        "except HysgenError as fault: print(fault)\n"
        "require_room(190 * 2**20)\n"
    )
    import subprocess

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(
        "[True, False, True]\nnot enough memory: the libraries of hysgen take 220 MB of address"
    )
    assert (processes.LIBRARIES >> 20, processes.THREAD >> 20) == (384, 144)


@pytest.mark.parametrize(
    ("cores", "room", "parent", "expected"),
    [(8, 99, None, 4), (3, 99, None, 3), (None, 99, None, 1), (8, 2, None, 2), (8, 0, None, 1), (8, 99, "a worker", 1)],
)
def test_threads_are_as_many_as_cores_memory_and_siblings_allow(
    cores: int | None, room: int, parent: Any, expected: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    class Pool:
        def __init__(self, count: int) -> None:
            asked.append(count)

        def __enter__(self) -> Any:
            return SimpleNamespace(map=map)

        def __exit__(self, *_: object) -> None:
            pass

    monkeypatch.setattr(processes, "ThreadPoolExecutor", Pool)
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: parent)
    monkeypatch.setattr(processes, "has_room", lambda size: size <= room * processes.THREAD)
    assert processes.in_threads(abs, [-1, 2, -3]) == [1, 2, 3]
    assert asked == ([expected] if expected > 1 else [])


def test_processes_are_as_many_as_are_asked_for_or_cores_up_to_four(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYSGEN_PROCESSES", "9")
    assert processes.processes() == 9
    monkeypatch.delenv("HYSGEN_PROCESSES")
    for cores, expected in ((1, 1), (3, 3), (4, 4), (64, 4)):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, cores=cores: set(range(cores)), raising=False)
        assert processes.processes() == expected
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: "a parent")
    assert processes.processes() == 1


def test_threads_are_counted_with_those_of_compiled_libraries() -> None:
    assert processes._threads() == len(os.listdir("/proc/self/task")) >= threading.active_count()


# Cache


def test_a_cache_forgets_what_was_used_longest_ago_and_counts_single_arrays_and_numbers() -> None:
    plain: LruCache[Any] = LruCache(2)
    for key in "aba":
        plain.get(key, lambda key=key: key * 2)
    plain.get("c", lambda: "cc")
    assert ["a" in plain, "b" in plain, "c" in plain] == [True, False, True]
    # Within its bytes: 80 + 80 + 1 are 161.
    for most, held in ((161, 3), (160, 2)):
        roomy: LruCache[Any] = LruCache(1, most)
        for key, value in (("a", np.zeros(10)), ("b", np.zeros(10)), ("c", 3)):
            roomy.get(key, lambda value=value: value)
        assert sum(key in roomy for key in "abc") == held
    one: LruCache[Any] = LruCache(1, 10)
    one.get("a", lambda: np.zeros(10))
    assert "a" in one, "the capacity is held whatever it takes"


# Numbers


def test_functions_of_one_number_are_correctly_rounded() -> None:
    assert (reproducible.exp(0.0), reproducible.expm1(0.0), reproducible.sine(0.0)) == (1.0, 0.0, 0.0)
    with localcontext() as context:
        context.prec = 80
        for x in (1e-20, -3e-9, 0.3, -1.7, 40.0):
            exact = Decimal(x).exp()
            assert reproducible.exp(x) == float(exact)
            assert reproducible.expm1(x) == float(exact - 1)
            assert reproducible.power(x, 7) == float(Decimal(x) ** 7)
    for x in (1e-9, 0.5, -1.0, math.pi / 2, 3.0, -4.0):
        assert abs(reproducible.sine(x) - math.sin(x)) <= math.ulp(math.sin(x)) / 2 + 1e-18
        assert reproducible.sine(-x) == -reproducible.sine(x)


def test_rounding_up_and_down_brackets_a_number_and_spacing_has_one_ratio() -> None:
    assert (reproducible.rounded_up(1.2301, 3), reproducible.rounded_down(1.2399, 3)) == (1.24, 1.23)
    assert (reproducible.rounded_up(-1.2399, 3), reproducible.rounded_down(-1.2301, 3)) == (-1.23, -1.24)
    assert (reproducible.rounded_up(math.inf, 3), reproducible.rounded_down(-math.inf, 3)) == (math.inf, -math.inf)
    for first, last, count in ((1.0, 16.0, 5), (0.3, 0.001, 2), (-2.0, -2e5, 7)):
        found = np.array(reproducible.geometric(first, last, count))
        assert (found[0], found[-1], found.size) == (first, last, count)
        assert np.allclose(found[1:] / found[:-1], (last / first) ** (1 / (count - 1)), rtol=1e-14)
    assert reproducible.geometric(1.0, 16.0, 5) == [1.0, 2.0, 4.0, 8.0, 16.0]


def test_an_array_is_summed_in_sequence_and_its_exponential_is_within_one_unit() -> None:
    x = np.random.default_rng(2).normal(size=(4, 50)) * 10.0 ** np.arange(50)
    assert reproducible.total(x).tolist() == [sum(row.tolist()) for row in x]
    assert reproducible.total(x, 0).tolist() == [sum(column.tolist()) for column in x.T]
    vector = np.arange(50.0) - 20.0
    assert reproducible.product(x, vector).tolist() == [sum((row * vector).tolist()) for row in x]
    at = np.concatenate([np.linspace(-745.0, 700.0, 2001), [-746.5, -1e300, 0.0, 1e-18]])
    exact = np.array([reproducible.exp(float(each)) for each in at])
    assert np.all(np.abs(reproducible.exponential(at) - exact) <= np.spacing(exact))
    assert reproducible.exponential(np.array([-747.0, -1e300])).tolist() == [0.0, 0.0]
    drawn = reproducible.drawn(np.random.default_rng(3), -2.0, 5.0, 1000)
    assert np.array_equal(drawn, -2.0 + 7.0 * np.random.default_rng(3).random(1000))


def test_a_spectral_radius_is_a_bound_of_nine_digits() -> None:
    A = np.array([[0.5, 2.0, 0.0], [-0.5, 0.5, 0.0], [1.0, 7.0, -0.9]])
    assert math.sqrt(1.25) <= reproducible.spectral_radius(A) == 1.11803399
    assert reproducible.spectral_radius(np.zeros((2, 2))) == 0.0
    # 0.5 twice, with one eigenvector: numbers off by 8 units move it by the root of 2^-52.
    twice = np.array([[1.0, 1.0], [-0.25, 0.0]])
    assert 0.5 + 2.0**-26 < reproducible.spectral_radius(twice) < 2.0001


def test_a_computation_that_cannot_be_written_is_an_error_of_the_cache_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from hysgen.machine import cache

    def full(*_: object) -> None:
        raise HysgenError("full")

    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(cache, "write_sealed", full)
    assert cache.resumed(("x",), tmp_path, lambda: 7) == 7


WINDOWS = """
import asyncio, mimetypes, os, sys, types
import concurrent.futures.process, matplotlib.pyplot, scipy.linalg  # these look at the platform themselves
calls = []
def locking(place, how, size):
    calls.append(how)
    if len(calls) == 1:
        raise OSError("ten seconds are over")
sys.modules |= {"fcntl": None, "msvcrt": types.SimpleNamespace(LK_LOCK=1, locking=locking)}
for name in {"getuid", "fork", "sched_getaffinity"} & set(dir(os)):
    delattr(os, name)
sys.platform = "win32"
from hysgen.cli import main
assert main(["generate", "appendix_a", "-o", sys.argv[1]]) == 0
assert calls == [1, 1], calls
"""


@pytest.mark.slow
def test_a_folder_is_generated_without_what_windows_has_not(tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-c", WINDOWS, str(tmp_path / "c")], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "c" / "appendix_a.c").exists()
