"""The firmware's image for the C6748: its boot image, what the verb says of it, time from A/D to D/A, the caches."""

import functools
import re
import subprocess
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from fixtures.boot_rom import BootRom
from fixtures.c674x_compiler import need_compiler
from fixtures.firmware_bench import model
from hysgen import firmware as binding
from hysgen.cli import main
from hysgen.cli.console import Console
from hysgen.errors import TargetError
from hysgen.firmware import firmware_model, with_learner
from hysgen.model.file import load_model
from hysgen_c674x import toolchain
from hysgen_c674x.caches import L1D_LINE, L1D_SETS, L1P_LINE, L1P_SETS, Caches, Misses
from hysgen_c674x.elf import MemorySection, ProgramImage, Symbol
from hysgen_c674x.firmware import boot_image as booting
from hysgen_c674x.firmware import timing
from hysgen_c674x.firmware.boot_image import boot_image
from hysgen_c674x.firmware.target import compile_image, link_image
from hysgen_c674x.firmware.timing import LEARN, LOOP, Timing, tracked
from hysgen_c674x.machine import Machine
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import AccessKind, Trace
from hysgen_c674x.schedule.folder import kernels, with_kernels


@pytest.mark.slow
def test_the_boot_rom_loads_what_the_linker_placed_and_jumps_to_reset(tmp_path: Path) -> None:
    need_compiler()
    built = link_image(model().name, firmware_model(model()))
    rom = BootRom(boot_image(built.firmware.image))
    rom.run()
    assert rom.entry == built.firmware.image.symbol("_c_int00").address
    assert rom.checks == 3
    # The same bytes by the linker's own tools: a flat binary from the first to the last loaded address.
    elf, flat = tmp_path / "firmware.out", tmp_path / "firmware.bin"
    elf.write_bytes(built.firmware.elf)
    objcopy = next((toolchain.folder() / "bin").glob("*-objcopy"))
    subprocess.run([objcopy, "-O", "binary", str(elf), str(flat)], check=True)
    expected, first = flat.read_bytes(), min(rom.memory)
    assert len(expected) <= max(rom.memory) + 1 - first < len(expected) + 4
    assert bytes(rom.memory.get(first + i, 0) for i in range(len(expected))) == expected


def program(*sections: MemorySection) -> ProgramImage:
    return ProgramImage(sections, {"_c_int00": Symbol("_c_int00", 0x1180_4400, 4, True)})


TEXT = MemorySection(".text", 0x1180_4000, 5, b"\1\2\3\4\5", False)


def test_a_section_is_padded_to_words_and_zeros_are_not_loaded() -> None:
    bss = MemorySection(".bss", 0x1180_5000, 64, b"", True)
    rom = BootRom(boot_image(program(bss, TEXT)))
    rom.run()
    assert [rom.memory[0x1180_4000 + i] for i in range(8)] == [1, 2, 3, 4, 5, 0, 0, 0]
    assert len(rom.memory) == 8


@pytest.mark.parametrize("address", [0x1180_0000, 0x1180_3FFC])
def test_content_in_the_boot_roms_memory_is_refused(address: int) -> None:
    with pytest.raises(TargetError, match="the boot ROM needs 0x11800000 to 0x11803fff"):
        boot_image(program(replace(TEXT, address=address)))


def test_a_flipped_bit_is_seen_by_the_reader() -> None:
    """The reader itself: every bit of address, size, content and CRC counts."""
    good = boot_image(program(TEXT))
    for bit in range(8 * 12, 8 * (8 + 12 + 8 + 8)):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << bit % 8
        with pytest.raises((AssertionError, IndexError)):
            BootRom(bytes(bad)).run()


def test_the_command_writes_the_image_or_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "no.out").write_bytes(b"no ELF")
    assert booting.main([str(tmp_path / "no.out"), str(tmp_path / "no.ais")]) == 1
    assert "not a little-endian 32-bit ELF" in capsys.readouterr().err
    assert booting.main([]) == 2


def test_the_table_of_cycles_has_a_row_for_each_state() -> None:
    run: Any = SimpleNamespace(
        interrupt={"TRACK": (1000, 3750)},
        idle=(10, 75),
        equal=True,
        differing=0,
        samples=9,
        commits=2,
        selftest=0,
        boot=77,
    )
    text = timing.cycles_table(run)
    assert "interrupt, TRACK  1000 .. 3750   50.0 %" in text
    assert "idle loop             10 .. 75    1.0 %" in text
    assert "9 samples, 2 commits: the host's bits; self-test at boot: 0 mismatches, 77 cycles" in text
    run.equal, run.differing = False, 4
    assert "9 samples, 2 commits: NOT THE HOST'S BITS in 4;" in timing.cycles_table(run)


def test_firmware_states_sections_bounds_and_cycles_and_what_the_simulator_lacks(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = SimpleNamespace(
        interrupt={},
        idle=(1, 2),
        equal=True,
        differing=0,
        samples=9,
        commits=0,
        selftest=0,
        boot=1,
        to_json=lambda: "run",
    )
    section = SimpleNamespace(name=".text", address=0x11800000, memory="L2", size=77)
    built = SimpleNamespace(sections=[section], used={"L2": 77}, compiler="gcc 12", to_json=lambda: "built")
    results: list[Any] = []
    monkeypatch.setattr(timing, "MEMORIES", {"L2": (0, 262_144)})
    monkeypatch.setattr(timing, "link_image", lambda name, texts: built)
    monkeypatch.setattr(timing, "compile_image", lambda texts: "compiled")
    monkeypatch.setattr("hysgen.cli.verbs.firmware.firmware_model", lambda model, **_: {"model.h": model.name})
    monkeypatch.setattr(timing, "static_bounds", lambda name, compiled: {"f": (3, 5), "g": None, compiled: (1, 1)})
    monkeypatch.setattr(timing, "simulate", lambda model, texts, compiled, samples: run if samples == 9 else 1 / 0)
    monkeypatch.setattr(timing, "timings", lambda model, compiled: {compiled: SimpleNamespace(to_json=lambda: "t")})
    monkeypatch.setattr(timing, "timing_rows", lambda timed, budget: [[str(budget)] * len(timing.TIMING_HEADS)])
    monkeypatch.setattr(Console, "write_json", lambda _, result: results.append(result))
    assert main(["firmware", "appendix_a", "--samples", "9"]) == 0
    out = capsys.readouterr().out
    for line in (
        r"\.text +0x11800000  L2 +77",
        r"L2: 77 of 262144 bytes",
        r"gcc 12",
        r"f +3 \.\. 5",
        r"g +not bounded",
    ):
        assert re.search(f"^{line}$", out, re.M), line
    assert "7500" in out.rpartition("nothing ran on silicon")[2], "the timing stands last, with the period's cycles"
    assert results[-1]["simulated"] == "run"
    assert results[-1]["timing"] == {"compiled": "t"}

    def lacks(*_: object) -> None:
        raise TargetError("no such instruction")

    monkeypatch.setattr(timing, "simulate", lacks)
    assert main(["firmware", "appendix_a", "--samples", "9"]) == 0
    assert capsys.readouterr().err == "warning: cycles are missing: no such instruction\n"
    assert (results[-1]["target"], results[-1]["simulated"], results[-1]["timing"]) == ("built", None, None)


def test_timings_are_of_the_loop_alone_with_the_learner_and_with_the_idle_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "tracked", lambda *what, **idle: (*what, idle))
    compiled: Any = SimpleNamespace(machine=lambda: "machine")
    assert timing.timings(model(), compiled) == {
        "loop": (model(), "machine", LOOP, {}),
        "loop, learner": (model(), "machine", LOOP | LEARN, {}),
        "loop, learner, idle loop": (model(), "machine", LOOP | LEARN, {"idle": True}),
    }


PAGE = Path(__file__).resolve().parents[3] / "docs" / "firmware_results.md"
FETCH, LOAD, STORE = AccessKind.FETCH, AccessKind.LOAD, AccessKind.STORE


@functools.cache
def without_and_with_learner() -> tuple[Timing, Timing]:
    compiled = compile_image(firmware_model(model()))
    return tracked(model(), compiled.machine(), LOOP), tracked(model(), compiled.machine(), LOOP | LEARN)


@pytest.mark.slow
def test_the_learner_delays_the_output_by_two_cycles_at_most() -> None:
    """From the reading to the voltage, sample by sample; without a commit the voltages are equal."""
    need_compiler()
    without, learning = without_and_with_learner()
    assert all(0 <= late - early <= 2 for late, early in zip(learning.delay, without.delay, strict=True))
    assert min(learning.total) > max(without.total)
    assert learning.cold.lines > without.cold.lines > without.warm.lines


@pytest.mark.golden
@pytest.mark.slow
def test_the_page_states_the_cycles_to_the_output() -> None:
    need_compiler()
    without, learning = without_and_with_learner()
    page = PAGE.read_text(encoding="utf-8")
    for name, each in {"loop": without, "loop, learner": learning}.items():
        row = f"| Appendix A, {name} | {min(each.delay)} .. {max(each.delay)} | {max(each.total)} |"
        assert row in page, row
    hitl = (PAGE.parents[1] / "hitl" / "README.md").read_text(encoding="utf-8")
    assert f"the page says {max(without.delay)} cycles" in hitl


@pytest.mark.slow
def test_a_learner_before_the_output_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    need_compiler()
    read = binding.read_sources
    behind = (
        "    hysgen_board_voltage(board, hysgen_controller_step(&self->controller, y_um, reference_um, amplifier));\n"
    )
    moved = (
        "    const float u_V = hysgen_controller_step(&self->controller, y_um, reference_um, amplifier);\n"
        "    hysgen_controller_learn(&self->controller);\n    hysgen_board_voltage(board, u_V);\n"
    )

    def planted(folder: str, *patterns: str) -> binding.Sources:
        return [(name, text.replace(behind, moved)) for name, text in read(folder, *patterns)]

    monkeypatch.setattr("hysgen_c674x.firmware.target.read_sources", planted)
    compiled = compile_image(firmware_model(model()))
    without, learning = (tracked(model(), compiled.machine(), options) for options in (LOOP, LOOP | LEARN))
    assert min(learning.delay) > max(without.delay) + 500


@pytest.mark.proof
def test_with_kernels_the_extended_model_learns_within_its_period() -> None:
    """Interrupt in TRACK with the learner, behind the idle loop: it ends in time at 6 cycles a missed line."""
    need_compiler()
    extended = with_learner(load_model("extended"))
    texts = firmware_model(extended, aligned=True)
    texts = with_kernels(extended.name, texts, kernels(extended.name, texts))
    found = tracked(extended, compile_image(texts).machine(), LOOP | LEARN, idle=True)
    assert found.left(7500, 6, found.warm) > 0
    assert found.warm.lines < 500


def trace(*accesses: tuple[AccessKind, int]) -> Trace:
    """A trace of (kind, address)."""
    made = Trace(len(accesses))
    for cycle, (kind, address) in enumerate(accesses):
        made.add(cycle, kind, address)
    return made


def packets(*addresses: int, size: int = 4) -> dict[int, Packet]:
    """Packets of `size` bytes."""
    return {at: Packet(at, at + size, (), (), 0, frozenset(), None) for at in addresses}


def test_program_lines_that_share_a_set_replace_each_other() -> None:
    base, far = 0x1180_0000, 0x1180_0000 + L1P_LINE * L1P_SETS
    run = trace((FETCH, base), (FETCH, base), (FETCH, far), (FETCH, base))
    assert Caches(packets(base, far)).run(run) == Misses(3, 0)


def test_a_packet_across_two_lines_fetches_both() -> None:
    base = 0x1180_0000 + L1P_LINE - 4
    assert Caches(packets(base, size=8)).run(trace((FETCH, base))) == Misses(2, 0)


def test_data_lines_replace_the_least_recently_used_of_two_and_stores_take_none() -> None:
    a, b, c = (0x1180_0000 + i * L1D_LINE * L1D_SETS for i in range(3))
    caches = Caches({})
    assert caches.run(trace((STORE, a), (LOAD, a), (LOAD, b), (LOAD, a))) == Misses(0, 2)
    # b was used least recently: c takes its place, a stays.
    assert caches.run(trace((LOAD, c), (LOAD, a), (LOAD, b))) == Misses(0, 2)


def test_engine_and_interpreter_trace_the_same_accesses() -> None:
    need_compiler()
    text = "float sum(const float *x); float sum(const float *x) { return x[0] + x[1] + x[2]; }"
    built = toolchain.compile([("sum.c", text)])
    found = []
    for interpreted in (False, True):
        machine = Machine(built.image, built.packets, interpreted)
        place = machine.allocate(4)
        machine.write(place, [1.0, 2.0, 3.0])
        outcome, made = machine.trace("sum", place)
        assert outcome.float32 == 6.0
        found.append(made.words[: made.count].tolist())
    assert found[0] == found[1]
    assert sum(word >> 32 & 3 == LOAD for word in found[0]) >= 2
