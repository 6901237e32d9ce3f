"""The image of main.c on the simulated C6748 from reset: boot, start by the link, tracking, NMI, watchdog.

Only the key is replaced: `make` links the same sources. The stage behind the converters is the model with noise.
Every word that the D/A gets is compared with the host's firmware on the same readings.
"""

import functools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fixtures.board_model import BoardModel, SimulatedLine, library
from fixtures.boot_rom import BootRom
from fixtures.c674x_compiler import need_compiler
from fixtures.firmware_bench import ModelStage, image, model, wave_V
from hysgen.cli.main import main
from hysgen.firmware import TARGET_BOARD, Label, build_id, encode, firmware_model, read_sources, with_learner
from hysgen.firmware.link import Client
from hysgen.firmware.wire import FirmwareStatus, Request, State
from hysgen.model.file import load_model
from hysgen.model.learner_settings import LEARNED, LearnerSettings
from hysgen.model.model import Model
from hysgen_c674x.firmware.boot_image import boot_image
from hysgen_c674x.firmware.target import link_image
from hysgen_c674x.machine import System
from hysgen_c674x.toolchain import Firmware
from hysgen_lab.firmware.host import HostFirmware
from hysgen_lab.stage import Stage, StageState

PERIOD = 7500
ZERO_UM, STEP_UM, DAC_LOW_V, DAC_PER_V = (np.float32(each) for each in (4.916, 0.00025, -20.0, 468.107143))
TABLE_UM = (2.0 + 0.6 * np.sin(2 * np.pi * np.arange(1024) / 1024)).astype(np.float32)
TRACKED = 4000

TEXT = """
hysgen firmware: model appendix_a, build {build:08x}
core 375 MHz, period 20000 ns
flash W25Q64JV: found
self-test: 0 words differ
settings: good
parameters: {parameters}
frames from here on
"""


OWN = {"ramp_V = 0.02f": "ramp_V = 0.05f", "loop_low_V = 22.0f": "loop_low_V = 23.0f"}
OWN |= {"loop_high_V = 56.0f": "loop_high_V = 55.0f"}
OF_ANOTHER = OWN | {"follow_um = 0.0f": "follow_um = 0.49f"}
"""The model of another stage is far off; that of the record has the bound that START finds."""


def linked(driven: Model, changes: dict[str, str]) -> Firmware:
    """The image of a model, with changes of main.c."""
    need_compiler()
    text = dict(read_sources(TARGET_BOARD))["main.c"]
    for old, new in changes.items():
        text = text.replace(old, new)
    return link_image(driven.name, firmware_model(driven) | {"main.c": text}).firmware


@functools.cache
def firmware() -> Firmware:
    """The linked image, with a key."""
    return linked(model(), {"{ { 0u, 0u, 0u, 0u }": "{ { 1u, 0u, 0u, 0u }"})


class Run:
    """The board from power on. read_um: at the A/D, one per conversion."""

    def __init__(self, built: Firmware | None = None, plant: Callable[[float], float] | None = None) -> None:
        self.built, own = built or firmware(), ModelStage(model(), 2e-4)
        self.plant = plant or (lambda u_V: own.step(None, u_V))
        self.read_um = list[float]()
        self.board = BoardModel(library(), self._sampled)
        script = boot_image(self.built.image)
        self.board.flash[: len(script)] = np.frombuffer(script, np.uint8)

    def _sampled(self, u_V: float) -> float:
        self.read_um.append(self.plant(u_V))
        return self.read_um[-1]

    def reset(self, before: System | None = None) -> System:
        """Reset; returns the system in front of its first interrupt, with the reference in place.

        before: the system before, whose memory behind the stack a reset under power leaves alone.
        """
        system = self.board.reset(self.built.image, self.built.packets)
        if before is not None:
            system.view("hysgen_start_kept", 2)[:] = before.view("hysgen_start_kept", 2)
        text = b""
        while not text.endswith(b"frames from here on\r\n\0"):
            assert system.run(PERIOD), "reset during the boot"
            assert system.cycle < 30_000_000, text
            text += self.board.sent()
            # Behind the clearing of .bss, which comes before the first text.
            if text:
                system.view("main_board", 1024)[:] = TABLE_UM
        self.text = text[:-1].decode()
        return system


def text_of(parameters: str) -> str:
    return TEXT.format(build=build_id(model()), parameters=parameters).replace("\n", "\r\n")


def start(client: Client, system: System) -> None:
    """START, until TRACK."""
    client.request(Request.START)
    at = 0
    while State(client.status().state) is not State.TRACK:
        at += 1
        assert at < 60
        assert system.run(500 * PERIOD)


@pytest.mark.slow
def test_the_image_from_reset_to_tracking_and_back() -> None:
    run = Run()
    rom = BootRom(bytes(run.board.flash[: len(boot_image(firmware().image))]))
    rom.run()
    system = run.reset()
    assert rom.entry == firmware().image.symbol("_c_int00").address
    first = min(rom.memory)
    loaded = np.array([rom.memory[first + i] for i in range(max(rom.memory) + 1 - first)], np.uint8)
    built = firmware().machine().view(first, loaded.size // 4, np.uint32).view(np.uint8)
    assert (loaded[: built.size] == built).all()

    assert run.text == text_of("built in")
    client = Client(SimulatedLine(run.board, system), timeout_s=60.0)
    assert client.identity().name == "appendix_a"
    status = client.status()
    assert (State(status.state), status.status, status.selftest, status.counter) == (State.OFF, 0, 0, 0)

    # A parameter image over the line into the flash, while interrupts run.
    status = client.install(encode(model(), bytes([1, *bytes(15)]), Label(0, build_id(model()), 7)))
    assert status.counter == 7
    assert run.board.state.flash_erased >= 1
    assert not run.board.violations

    # Tracking: the same words for the D/A as the host's firmware puts out on the same readings.
    start(client, system)
    begun = run.board.state.conversions
    assert system.run(TRACKED * PERIOD)
    status = client.status()
    assert State(status.state) is State.TRACK
    assert status.status >> 16 == 0
    assert status.cycles_most < PERIOD
    assert differing_words(run) == 0
    assert run.board.state.conversions - begun >= TRACKED
    assert abs(run.board.state.dog_served - run.board.state.interrupts) <= 1
    assert not run.board.violations

    # NMI: the amplifier off, the word of the D/A as it was; nobody serves the watchdog, which resets within 10 ms.
    system.raise_nmi()
    assert system.run(2000)
    assert not run.board.enabled
    assert not system.run(600 * PERIOD)
    assert system.cycle > 400 * PERIOD

    system = run.reset(before=system)
    assert run.text == text_of("image 7")
    client = Client(SimulatedLine(run.board, system), timeout_s=60.0)
    assert FirmwareStatus(client.status().first_fault) == FirmwareStatus.FAULT_EXCEPTION
    assert State(client.status().state) is State.TRIPPED
    assert not run.board.enabled
    assert not run.board.violations

    # A table is played, and its record comes out of the shared RAM.
    client.request(Request.CLEAR)
    table_V = np.linspace(20.0, 30.0, 100)
    _, put_V, read_um = client.record(np.arange(100) * 20e-6, table_V)
    assert np.abs(put_V - table_V).max() < 0.002
    assert np.isfinite(read_um).all()
    assert not run.board.violations

    # A constant that changes: a round over all words of the image takes 3000 samples at most.
    assert 4096 < client.status().stack_bytes <= 7168
    system.view(firmware().image.symbol("main_settings").address, 1, np.uint32)[0] ^= 8
    assert system.run(6000 * PERIOD)
    assert FirmwareStatus.FAULT_MEMORY in FirmwareStatus(client.status().status)


def differing_words(run: Run) -> int:
    """Words of the D/A, sample by sample since reset, that differ from the host's on the same readings."""
    codes = np.clip(np.rint((np.array(run.read_um) - 4.916) / 0.00025), -32768, 32767)
    readings = ZERO_UM + STEP_UM * codes.astype(np.float32)
    # The voltage of sample k acts when conversion k + 1 starts.
    words = np.rint((np.array(run.board.voltages[1:]) + 20.0) * (65535 / 140)).astype(np.int64)
    off = int(np.float32(20.0) * DAC_PER_V + np.float32(0.5))
    rising = int(np.flatnonzero(words[1:] != off)[0]) + 1
    # START reached the sample in which the voltage of the host, started at its first sample, has its first step.
    plant = Replayed(readings)
    host = HostFirmware(image(), plant)
    host.request(Request.START)
    ahead = 0
    while word(host.run(TABLE_UM[:1]).output_V)[0] == off:
        ahead += 1
    started = rising - ahead
    plant = Replayed(readings)
    host = HostFirmware(image(), plant)
    count = words.size
    reference = np.tile(TABLE_UM, count // 1024 + 1)[:count]
    before = host.run(reference[:started])
    host.request(Request.START)
    after = host.run(reference[started:])
    expected = word(np.concatenate([before.output_V, after.output_V]))
    return int((expected != words).sum())


def word(voltage_V: np.ndarray) -> np.ndarray:
    """Codes of the D/A as hysgen_board_voltage computes them in float32."""
    return ((voltage_V - DAC_LOW_V) * DAC_PER_V + np.float32(0.5)).astype(np.int64)


class Replayed(ModelStage):
    """A plant that repeats readings."""

    def __init__(self, readings: np.ndarray) -> None:
        super().__init__(model())
        self._readings = iter(readings.astype(float).tolist())
        self.y_um = next(self._readings)

    def step(self, _: object, u_V: float) -> float:
        """The next reading; the last one is repeated."""
        self.y_um = next(self._readings, self.y_um)
        return self.y_um


def tracked_nm(run: Run, client: Client, system: System) -> float:
    """Tracking error (rms) over four periods of the table, whose phase is fitted."""
    start(client, system)
    begun = len(run.read_um)
    assert system.run(5200 * PERIOD)
    last = client.status()
    assert (State(last.state), last.first_fault, run.board.violations, last.cycles_most < PERIOD) == (6, 0, [], True)
    read_um = np.array(run.read_um[begun + 1024 : begun + 5120]).reshape(4, 1024)
    return float(1e3 * min(np.sqrt(np.mean((read_um - np.roll(TABLE_UM, by)) ** 2)) for by in range(1024)))


@pytest.mark.proof
def test_from_board_to_record_to_diagnosis_to_image_to_board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stage is the laboratory's, not a model; the board that takes the record drives another one."""
    monkeypatch.chdir(tmp_path)
    rows = (f"{20e-6 * k:.9g},{u_V:.9g}" for k, u_V in enumerate(wave_V(18_000)))
    Path("table.csv").write_text("\n".join(("time_s,voltage_V", *rows, "")))
    errors_nm, driven = [], model()
    for seed in (5, 6):
        stage = StageState(replace(Stage.laboratory(), zero_V=23.0), 20e-6, seed)
        run = Run(linked(driven, OF_ANOTHER if driven is model() else OWN), stage.step)
        system = run.reset()
        line = SimulatedLine(run.board, system)
        if driven is model():
            monkeypatch.setattr("hysgen.cli.verbs.firmware.open_line", lambda *_, line=line: line)
            with monkeypatch.context() as timed:
                # An answer may take as long as the simulator, whose clock the client reads.
                timed.setattr("hysgen.firmware.link.time.monotonic", lambda system=system: system.cycle / 375e6)
                assert main(["link", "port", "record", "table.csv", "-o", "record.csv"]) == 0
            assert main(["diagnose", "record.csv", "-o", "stage.json"]) == 0
            driven = with_learner(load_model(Path("stage.json")))
            # What is named on the record leaves no cycles for a full learner.
            driven = replace(driven, learner=replace(driven.learner or LearnerSettings(), learned=LEARNED["gain"]))
        errors_nm.append(tracked_nm(run, Client(line, timeout_s=60.0), system))
    print("tracking error {:.1f} -> {:.1f} nm rms".format(*errors_nm))
    assert errors_nm[1] < 0.2 * errors_nm[0]
