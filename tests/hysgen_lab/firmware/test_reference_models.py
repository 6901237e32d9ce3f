"""The firmware's reference models, its image for the C6748, its run on the simulator, its tracking errors."""

import dataclasses
import difflib
import functools
import re
from pathlib import Path

import pytest

from fixtures.c674x_compiler import need_compiler
from hysgen.codegen.manifest import write
from hysgen.errors import ModelError
from hysgen.firmware import firmware_model, with_learner
from hysgen.firmware.wire import Settings
from hysgen.model.file import load_model
from hysgen_c674x.firmware.target import MEMORIES, compile_image, link_image, simulate, static_bounds
from hysgen_lab.firmware.reference_models import firmware_models
from hysgen_lab.firmware.tracking import controllers, diagnosed_controllers, run_controller, sensor_noise_nm

FOLDERS = Path(__file__).resolve().parents[3] / "firmware" / "models"
PAGE = FOLDERS.parents[1] / "docs" / "firmware_results.md"
MODELS = {model.name: model for model in firmware_models()}


@functools.cache
def generated(name: str) -> dict[str, str]:
    """What the templates make of one of MODELS."""
    return firmware_model(MODELS[name])


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.golden
@pytest.mark.slow
def test_the_models_in_the_firmware_are_what_the_templates_make(name: str, request: pytest.FixtureRequest) -> None:
    """Update with `pytest tests/hysgen_lab/firmware/test_reference_models.py --update-golden` and look at the diff."""
    folder, texts = FOLDERS / name, generated(name)
    if request.config.getoption("--update-golden"):
        write(texts, folder)
    files = [path for path in folder.rglob("*") if path.is_file()]
    kept = {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in files}
    assert sorted(kept) == sorted(texts)
    for file, text in texts.items():
        change = difflib.unified_diff(kept[file].splitlines(), text.splitlines(), "kept", "generated", lineterm="")
        assert kept[file] == text, f"{file}:\n" + "\n".join(list(change)[:60])


linked = functools.cache(lambda name: link_image(name, generated(name)))
compiled = functools.cache(lambda name: compile_image(generated(name)))
longest = functools.cache(lambda name: static_bounds(name, compiled(name)))


def on_page(row: str, name: str) -> str:
    """The cell of docs/firmware_results.md in the row that begins with `row`, in the column of the model."""
    found = [
        line for line in PAGE.read_text(encoding="utf-8").splitlines() if re.match(rf"\| {re.escape(row)}\b", line)
    ]
    assert len(found) == 1, (row, found)
    return found[0].strip("| ").split(" | ")[{"appendix_a": -2, "extended": -1}[name]]


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.slow
def test_the_image_links_into_the_targets_memories(name: str) -> None:
    need_compiler()
    built = linked(name)
    assert {section.name for section in built.sections} == {".vectors", ".text", ".rodata", ".bss", ".stack", ".kept"}
    assert all(size <= MEMORIES[memory][1] for memory, size in built.used.items())
    symbols = built.firmware.image.symbols
    # No function of the compiler's library: its copy uses a hardware loop, whose counter the interrupt does not save.
    assert not [symbol for symbol in symbols if symbol.startswith("__c6xabi")]
    assert "sploop" not in built.firmware.listing
    # Reset at the start of the table, interrupt 4 four fetch packets further on.
    assert symbols["hysgen_vectors"].address == 0x11804000
    assert {"hysgen_main_tick", "tick", "hysgen_firmware_interrupt", "hysgen_controller_step"} <= symbols.keys()


def test_the_board_to_fill_in_comes_with_the_settings_that_the_host_tries() -> None:
    main = (FOLDERS.parent / "board" / "c6748" / "main.c").read_text(encoding="utf-8")
    written = {name: float(value) for name, value in re.findall(r"^    \.(\w+) = ([-\d.]+)[fu],$", main, re.MULTILINE)}
    tried = dataclasses.asdict(Settings())
    assert not any(tried.pop(option) for option in ("loop", "learn", "keep", "no_offset"))
    assert written == pytest.approx({"options": 0} | tried, rel=1e-7)


@pytest.mark.parametrize("name", [pytest.param("appendix_a", marks=pytest.mark.proof), "extended"])
@pytest.mark.slow
def test_interrupt_and_idle_loop_on_the_simulator_have_the_hosts_bits(name: str) -> None:
    need_compiler()
    # Long enough for the firmware to learn, try what it learnt on 64 samples, and commit.
    settings = MODELS[name].learner
    assert settings is not None
    brisk = dataclasses.replace(MODELS[name], learner=dataclasses.replace(settings, settle=256))
    texts = firmware_model(brisk)
    run = simulate(brisk, texts, compile_image(texts), 2500)
    assert run.equal
    assert run.commits >= 1
    assert {"POWER", "RISE", "LOOP", "HOLD", "APPROACH", "TRACK"} == run.interrupt.keys()
    # The static bound contains learn_init and learn, and states that exclude each other: no sample takes it.
    interrupt = longest(name)["hysgen_firmware_interrupt"]
    assert interrupt is not None
    assert max(most for _, most in run.interrupt.values()) <= min(interrupt[1], 7500)


@pytest.mark.parametrize("name", [pytest.param("appendix_a", marks=pytest.mark.proof), "extended"])
@pytest.mark.golden
@pytest.mark.slow
def test_the_page_states_sizes_and_cycles(name: str) -> None:
    need_compiler()
    built = linked(name)
    assert [on_page(each.name, name) for each in built.sections] == [str(each.size) for each in built.sections]
    assert on_page("of 262144", name) == str(built.used["L2 RAM"])
    for symbol, cycles in longest(name).items():
        assert cycles is not None
        assert on_page(symbol.removeprefix(f"{name}_"), name) == f"{cycles[0]} .. {cycles[1]}"


@pytest.mark.slow
def test_the_extended_inverse_tracks_three_times_better_than_the_papers() -> None:
    paper, extended, trimmed = (run_controller(controller, 50.0, 0.5) for controller in controllers(50.0)[:3])
    assert extended.rms_nm < paper.rms_nm / 3
    # `python -m hysgen_lab track` prints the result of 10 s at both frequencies.
    assert extended.rms_nm < 10.0
    assert trimmed.rms_nm < extended.rms_nm


@pytest.mark.proof
@pytest.mark.slow
def test_a_record_its_diagnosis_and_its_loop_track_to_twice_the_noise() -> None:
    alone, looped = (run_controller(controller, 50.0, 0.5) for controller in diagnosed_controllers())
    assert looped.rms_nm < min(2.0 * sensor_noise_nm(), 0.5 * alone.rms_nm)


def test_what_the_firmware_cannot_drive_is_refused_with_the_reason() -> None:
    with pytest.raises(ModelError, match="no learner settings"):
        firmware_model(load_model("appendix_a"))
    assert with_learner(load_model("appendix_a")).learner is not None
