"""The generated C itself: bits of chained runs, warnings, guards, and what may not stand in it."""

import functools
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fixtures.generated_models import everything, learning, smooth
from fixtures.tools import need
from hysgen.checking import Host
from hysgen.checking.proof.static import wall_flags
from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import write
from hysgen.float32.reference.instance import Instance
from hysgen.model.file import load_model
from hysgen.model.model import Model

MODELS = {model.name: model for model in (load_model("appendix_a"), everything(), smooth(2), smooth(50), learning())}


@functools.cache
def generated(name: str) -> dict[str, str]:
    return generate(MODELS[name])


@pytest.mark.parametrize("function", ["predict", "simulate", "inverse"])
@pytest.mark.slow
def test_chained_run_of_c_equals_chained_run_of_reference_bit_for_bit(function: str) -> None:
    """Both run in a row, without the induction that verify uses: it has to come to the same."""
    model = everything()
    host = Host(model.name, generated("everything"))
    rng = np.random.default_rng(20240501)
    y, u, y_next, channel = (
        rng.uniform(low, high, 1500).astype(np.float32)
        for low, high in ((0.3, 4.1), (-30.0, 130.0), (0.3, 4.1), (15.0, 30.0))
    )
    y[::97], u[::89], y[5::101], y_next[::83], channel[::77] = np.nan, np.inf, -np.inf, np.nan, np.nan
    inputs = {"predict": [y, u], "simulate": [u], "inverse": [y, y_next]}[function]

    struct = host.instance(2.0, 30.0)
    words = host.layout(f"{model.name}_t")["bank[0].slope[0]"]
    out, trace = host.run(function, struct, [column.view(np.uint32) for column in (*inputs, channel)], words=words)

    lane = Instance(model, np.full(1, 2.0, np.float32), np.full(1, 30.0, np.float32))
    for k in range(y.size):
        lane.aux([channel[k : k + 1]])
        result = getattr(lane, function)(*(column[k : k + 1] for column in inputs))
        assert result.view(np.uint32)[0] == out[k], f"{function}: sample {k}"
        assert [int(word[0]) for word in lane.words().values()] == trace[k, 1:].tolist(), (
            f"{function}: after sample {k}"
        )


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("name", ["everything", "smooth_50"])
@pytest.mark.slow
def test_no_warning_passes_the_wall_without_optimisation(name: str, compiler: str, tmp_path: Path) -> None:
    """At -O2, tests/checking/test_static.py has more models."""
    need(compiler)
    write(generated(name), tmp_path)
    assert compiled(compiler, " ".join(wall_flags(compiler, "-O0")), tmp_path, MODELS[name]) == ""


def test_the_wall_stands(tmp_path: Path) -> None:
    """A comparison of floats, planted, is refused: so silence means something."""
    need("gcc")
    model = load_model("appendix_a")
    texts = generate(model)
    texts["appendix_a.c"] = texts["appendix_a.c"].replace("(uint32_t)(x < low)", "(uint32_t)(x == low)")
    write(texts, tmp_path)
    assert "float-equal" in compiled("gcc", " ".join(wall_flags("gcc")), tmp_path, model)


@pytest.mark.parametrize("flags", ["-ffast-math", "-m32 -mfpmath=387 -ffreestanding"])
def test_flags_that_change_bits_are_refused_at_compile_time(flags: str, tmp_path: Path) -> None:
    need("gcc")
    model = load_model("appendix_a")
    write(generate(model), tmp_path)
    complaint = compiled("gcc", f"-std=c99 -O2 {flags}", tmp_path, model)
    assert "#error" in complaint


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.slow
def test_nothing_forbidden_stands_in_the_code(name: str) -> None:
    """No division, no double, no library, no allocation, no goto, no writable global, no open-ended loop."""
    for file in (f"{name}.c", f"{name}.h", f"{name}_params.h", f"{name}_selftest.c"):
        text = re.sub(r"#ifdef __cplusplus\n.*?#endif", "", generated(name)[file], flags=re.DOTALL)
        code = re.sub(r'/\*.*?\*/|"[^"\n]*"', "", text, flags=re.DOTALL)
        assert "/" not in code
        assert not re.search(r"\b(double|long|malloc|goto|while|do|extern)\b", code.replace("__asm__ volatile", ""))
        assert set(re.findall(r"#include (.*)", code)) <= {"<stdint.h>", "<float.h>", "<limits.h>", ""}
        assert all("const" in line for line in re.findall(r"^static [^()]*(?:=|;).*$", code, re.MULTILINE))
        assert not re.search(r"\b\d+\.\d*(?![\d.]*[ef\d])", code), "a number without f would be a double"
        assert not re.search(r"^(?:\w+ )?\w+ = |^\(void\)|^(?:if|for|return)\b", code, re.MULTILINE), "not indented"


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.slow
def test_self_test_finds_nothing_and_finds_a_changed_bit(name: str) -> None:
    texts = generated(name)
    assert Host(name, texts).call("selftest") == 0
    wrong = texts[f"{name}.c"].replace("12582912.0f;", "12582914.0f;", 1)
    assert Host(name, texts | {f"{name}.c": wrong}).call("selftest") > 0


def test_files_compile_freestanding_and_need_no_library(tmp_path: Path) -> None:
    need("gcc")
    model = everything()
    write(generated("everything"), tmp_path)
    assert compiled("gcc", "-std=c99 -O2 -ffreestanding", tmp_path, model) == ""
    needed = subprocess.run(
        ["nm", "-u", *(str(path) for path in tmp_path.glob("*.o"))], capture_output=True, text=True, check=True
    ).stdout
    outside = {line.split()[-1] for line in needed.splitlines() if line.strip().startswith("U")}
    # GCC may call the four memory functions even freestanding; everything else is the model's own.
    assert all(name.startswith(model.name) or name in {"memcpy", "memset", "memmove"} for name in outside), outside


def test_model_without_inverse_has_none() -> None:
    texts = generate(load_model("appendix_a"), Options(inverse=False))
    assert not any("inverse" in texts[f"appendix_a{end}"] for end in (".c", ".h", "_params.h", "_selftest.c"))


def compiled(compiler: str, flags: str, folder: Path, model: Model) -> str:
    """What the compiler says of both units, "" if nothing."""
    said = ""
    for unit in (f"{model.name}.c", f"{model.name}_selftest.c"):
        call = [compiler, *flags.split(), "-c", "-o", f"{unit[:-2]}.o", unit]
        said += subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False).stderr
    return said
