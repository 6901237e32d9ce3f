"""Parameters and settings read and written over the link, and kept over power off like any image."""

# Safety case: [S3], [S9]

import json
import struct
import zlib
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.firmware_bench import KEY, REFERENCE_UM, Direct, booted, model, sine
from hysgen.cli.main import main
from hysgen.errors import HysgenError, ModelError
from hysgen.firmware import Label, ParameterImage, encode, pack
from hysgen.firmware.link import Client, kept_text, read_kept
from hysgen.firmware.wire import Request, Settings, State
from hysgen_lab.firmware.host import SLOT_BYTES, HostFirmware

BUILT = Settings(power_samples=7)
OTHER = replace(BUILT, learn=True, low_V=-5.5, hold_samples=77, offset_um=0.75, reading_gain=1.01, output_zero_V=-0.3)


def board(settings: Settings = BUILT) -> tuple[HostFirmware, Client]:
    firmware = booted(settings)
    return firmware, Client(Direct(firmware))


def used(firmware: HostFirmware) -> Settings:
    """The settings in use, as the C has them."""
    ffi = firmware.image.library.ffi
    return Settings.unpack(bytes(ffi.buffer(firmware.firmware.controller.settings)))


def with_settings(kept: ParameterImage, settings: Settings) -> ParameterImage:
    return replace(kept, settings=settings.pack())


def test_the_words_of_the_settings_are_the_fields_of_settings_t_in_its_order() -> None:
    firmware, _ = board(OTHER)
    for field in fields(Settings)[4:]:
        assert getattr(firmware._settings, field.name) == np.float32(getattr(OTHER, field.name)), field.name
    assert firmware._settings.options == 2
    assert used(firmware) == OTHER


def test_settings_that_are_written_are_those_of_the_next_boot_and_stay() -> None:
    firmware, client = board()
    kept = client.stored()
    assert (Settings.unpack(kept.settings), kept.label.counter) == (BUILT, 0)
    status = client.keep(with_settings(kept, OTHER), KEY)
    assert (status.counter, used(firmware)) == (1, BUILT)
    assert Settings.unpack(client.stored().settings) == OTHER
    firmware.boot()
    assert used(firmware) == Settings.unpack(client.stored().settings) == OTHER
    # Calibration and the rest act: as built, 1.01 of the reading and 0.3 V less.
    assert (firmware.board.gain_um, firmware.board.zero_V) == (np.float32(1.01), np.float32(-0.3))
    # Another model leaves them; an image without settings brings those of the build back.
    assert client.install_model(replace(model(), consequents=model().consequents * [1.0, 0.99, 1.0]), KEY).counter == 2
    firmware.boot()
    assert used(firmware) == OTHER
    client.install(encode(model(), KEY, Label(counter=3)))
    firmware.boot()
    assert used(firmware) == BUILT


@pytest.mark.parametrize("wrong", [{"step_V": 99.0}, {"reading_gain": 0.0}, {"low_V": float("nan")}], ids=str)
def test_settings_that_must_not_run_are_refused_and_nothing_is_kept(wrong: dict[str, Any]) -> None:
    firmware, client = board()
    kept = client.stored()
    with pytest.raises(ModelError, match="must not run"):
        client.keep(with_settings(kept, replace(OTHER, **wrong)), KEY)
    assert firmware.firmware.image_answer == 18
    firmware.boot()
    assert used(firmware) == BUILT
    assert client.stored().settings == kept.settings


def test_stored_settings_that_the_next_build_refuses_leave_the_built_in_ones_and_the_counter() -> None:
    """As a build with narrower limits finds them."""
    firmware, client = board()
    client.keep(with_settings(client.stored(), OTHER), KEY)
    wide = pack(with_settings(replace(client.stored(), label=Label(counter=9)), replace(OTHER, ramp_V=9.0)), KEY)
    seal = struct.pack("<3I", 0x4C414553, 7, struct.unpack("<I", wide[-12:-8])[0])
    seal += struct.pack("<I", zlib.crc32(seal))
    firmware.slot(1)[:] = wide.ljust(SLOT_BYTES - len(seal), b"\xff") + seal
    firmware.boot()
    assert (firmware.firmware.store.counter, firmware.firmware.store.slot) == (9, 0)
    assert used(firmware) == OTHER
    firmware.slot(0)[:] = b"\xff" * SLOT_BYTES
    firmware.boot()
    assert (firmware.firmware.store.counter, used(firmware)) == (9, BUILT)


def test_learnt_parameters_survive_power_off_once_they_are_written() -> None:
    firmware, client = board(replace(BUILT, learn=True, keep=True, follow_um=0.49))
    built_in = firmware.bank()
    firmware.start(REFERENCE_UM)
    firmware.run(sine(60_000))
    with pytest.raises(HysgenError, match="at rest; STOP first"):
        client.stored()
    firmware.request(Request.STOP)
    firmware.run(np.full(4000, REFERENCE_UM))
    assert firmware.state is State.OFF
    learnt = firmware.bank()
    assert learnt != built_in
    client.keep(client.stored(), KEY)
    firmware.boot()
    assert firmware.bank() == learnt
    firmware.start(REFERENCE_UM)
    assert firmware.state is State.TRACK


def test_the_verb_reads_a_file_that_it_writes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    firmware, client = board()
    monkeypatch.setattr("hysgen.cli.verbs.firmware.open_line", lambda *_: Direct(firmware))
    file, key = tmp_path / "kept.json", tmp_path / "key"
    key.write_text(KEY.hex())
    assert main(["link", "port", "read", "-o", str(file)]) == 0
    given = json.loads(file.read_text())
    assert given["half_integral"] == 0.002
    given["settings"]["reading_gain"] = 1.02
    file.write_text(json.dumps(given))
    assert main(["link", "port", "write", str(file), "--key", str(key)]) == 0
    firmware.boot()
    assert used(firmware) == replace(BUILT, reading_gain=1.02)
    assert kept_text(read_kept(file)) == kept_text(replace(client.stored(), label=Label()))
    for text in ("[]", "{}", json.dumps({**given, "structure": "00"}), json.dumps({**given, "settings": {"a": 1}})):
        file.write_text(text)
        with pytest.raises(ModelError, match="is not as hysgen link read writes it"):
            read_kept(file)
    with pytest.raises(ModelError, match="cannot be read"):
        read_kept(tmp_path / "none")
