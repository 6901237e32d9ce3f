"""What the firmware's tests stand on: the image of the paper's model, on the virtual stage with all its effects."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from hysgen.firmware.binding import firmware_model
from hysgen.firmware.host import HostFirmware, Image, Settings
from hysgen.learning import LearnerSettings
from hysgen.model import Model
from hysgen.model_file import load_model
from hysgen.native import Toolchain, default_toolchain
from hysgen.stage import Stage, StageState

SENSOR_ZERO_V = 23.0
REFERENCE_UM = 2.0
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wstrict-prototypes", "-Wdouble-promotion", "-pedantic")


@functools.cache
def model() -> Model:
    """Appendix A with a learner, spread over four calls."""
    return replace(load_model("appendix_a"), learner=LearnerSettings(calls_per_update=4))


@functools.cache
def image() -> Image:
    """Its host image, compiled without a warning."""
    toolchain = Toolchain(default_toolchain().command, ("-O2", "-Werror", *WARNINGS))
    return Image.compile(model().name, firmware_model(model()), toolchain)


def booted(settings: Settings | None = None, seed: int = 5) -> HostFirmware:
    """The image on a laboratory stage that has rested at 0 V, just booted."""
    stage = replace(Stage.laboratory(), zero_V=SENSOR_ZERO_V)
    return HostFirmware(image(), StageState(stage, 20e-6, seed), settings)


def tracking(settings: Settings | None = None, seed: int = 5) -> HostFirmware:
    """The same, started, following a constant reference."""
    firmware = booted(settings, seed)
    firmware.start(REFERENCE_UM)
    return firmware


def sine(samples: int, f_Hz: float = 50.0) -> np.ndarray:
    """References of section 4.3, (samples,) in um."""
    return REFERENCE_UM + 0.6 * np.sin(2 * np.pi * f_Hz * 20e-6 * np.arange(samples))
