"""Section 4.3 with the complete firmware: 10 s of y_d = 2.0 + 0.6 sin(2 pi f t) um on the virtual laboratory stage.

The stage has hysteresis, a pole of 1 ms, an amplifier of 10 kHz with a rate limit, creep, a mode at 780 Hz, drift,
mains hum, and a sensor with noise and finite resolution. Each controller gets this stage after its identification input
and a ramp to 0 V. The firmware then starts up, drives the initial loop, measures the offset, and tracks the reference.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import HysgenError
from hysgen.firmware import firmware_model, with_learner
from hysgen.firmware.wire import Settings, State
from hysgen.fitting import FitSettings
from hysgen.model.model import Model
from hysgen.model.path import preview
from hysgen.model.rivals import fit_proportional
from hysgen_lab.firmware.host import HostFirmware, HostImage
from hysgen_lab.firmware.reference_models import (
    TS_S,
    diagnosed,
    diagnosed_drive,
    driven,
    extended,
    extended_drive,
    identified,
    laboratory,
    measured,
)
from hysgen_lab.stage import StageState, signals

Floats = NDArray[np.float64]
Progress = Callable[[float, str], None]

SECONDS: Final = 10.0
FREQUENCIES_HZ: Final = (50.0, 100.0)
REST_S: Final = 0.2
"""Time at 2.0 um before the sine begins, in s; not scored."""

SEED: Final = 43
PAPER_NM: Final = {50.0: 18.6, 100.0: 15.2}
"""Tracking error rms in nm that the paper reports for its inverse, by frequency in Hz."""


@dataclass(frozen=True)
class TrackingResult:
    """One controller at one frequency: reading minus reference over all scored samples.

    rms_nm: rms with the sensor's noise; mean_nm, spread_nm: mean and standard deviation; last_nm: rms of the last
    second. voltage_V: lowest and highest voltage. commits: accepted commits. status: of the firmware at the end.
    """

    controller: str
    f_Hz: float
    rms_nm: float
    mean_nm: float
    spread_nm: float
    last_nm: float
    voltage_V: tuple[float, float]
    commits: int
    status: str


@dataclass(frozen=True)
class Controller:
    """A model and firmware settings. drive_V: input that identified the model, applied to the stage beforehand."""

    name: str
    model: Model
    settings: Settings
    drive_V: Floats


def track(seconds: float = SECONDS, progress: Progress | None = None) -> tuple[list[TrackingResult], float]:
    """Run every controller at every frequency. Returns the results and the sensor's noise in nm rms.

    Raises HysgenError if a firmware does not start, FitError if a fit fails, BuildError if a compilation fails.
    """
    results: list[TrackingResult] = []
    of_diagnosis = diagnosed_controllers()
    total = len(FREQUENCIES_HZ) * (5 + len(of_diagnosis))

    def report(fraction: float, what: str) -> None:
        if progress is not None:
            progress((len(results) + fraction) / total, what)

    for f_Hz in FREQUENCIES_HZ:
        report(0.0, f"proportional, {f_Hz:g} Hz")
        results.append(_proportional(f_Hz, seconds))
        for controller in (*controllers(f_Hz), *of_diagnosis):
            results.append(run_controller(controller, f_Hz, seconds, report))
    return results, sensor_noise_nm()


def controllers(f_Hz: float) -> list[Controller]:
    """The paper's model, identified from the paper's signal for this frequency, and `extended` with three settings.

    With the signal of Fig. 5, Eq. (10) gives |df/dy| = 1.08 at the end of the range; firmware needs a certified model.
    The least-squares optimum inside the certified set replaces it. Where Eq. (10) is certified, both are the same.
    """
    paper_V = signals.fig8(TS_S, "identification") if f_Hz == 50.0 else signals.fig5(TS_S, "identification")
    paper = with_learner(identified(paper_V, FitSettings(name="paper", method="batch")))
    model, drive_V = extended(), extended_drive()
    settings = settings_for(model)
    return [
        # The offset of a model without memory differs between rest and motion: correcting by it at rest adds error.
        Controller("paper's inverse", paper, replace(settings_for(paper), no_offset=True), paper_V),
        Controller("extended inverse", model, settings, drive_V),
        Controller("extended, feedback", model, replace(settings, loop=True), drive_V),
        Controller("extended, learning", model, replace(settings, learn=True), drive_V),
    ]


def diagnosed_controllers() -> list[Controller]:
    """What a diagnosis of one record delivers, alone and with the loop that is designed around it."""
    model, drive_V = diagnosed(), diagnosed_drive()
    settings = settings_for(model)
    return [
        Controller("diagnosed inverse", model, settings, drive_V),
        Controller("diagnosed, loop", model, replace(settings, loop=True), drive_V),
    ]


def settings_for(model: Model) -> Settings:
    """The default settings, with the initial loop over the input range of the model."""
    return Settings(loop_low_V=model.u_min_V, loop_high_V=model.u_max_V)


def sensor_noise_nm() -> float:
    """Rms of white noise and quantisation of the laboratory's sensor, in nm."""
    stage = laboratory()
    white_um = stage.noise.white_um if stage.noise else 0.0
    return 1e3 * float(np.hypot(white_um, stage.sensor_step_um / np.sqrt(12.0)))


def at_rest(drive_V: Floats) -> StageState:
    """State of the laboratory stage after the input `drive_V` and a ramp to 0 V."""
    state, _ = driven(drive_V, SEED)
    down_V = np.linspace(float(drive_V[-1]), 0.0, 2500)
    state.advance(down_V, np.zeros((down_V.size, 0)))
    return state


def _reference(f_Hz: float, seconds: float) -> Floats:
    sine_um = signals.tracking_reference(TS_S, f_Hz, seconds)
    return np.concatenate([np.full(round(REST_S / TS_S), sine_um[0]), sine_um])


def run_controller(
    controller: Controller, f_Hz: float, seconds: float, progress: Progress = lambda _, __: None
) -> TrackingResult:
    """Track one frequency with the compiled firmware. Raises HysgenError if it does not reach TRACK."""
    model = controller.model
    image = HostImage.compile(model.name, firmware_model(model))
    firmware = HostFirmware(image, at_rest(controller.drive_V), controller.settings)
    reference_um = _reference(f_Hz, seconds)
    firmware.start(float(reference_um[0]))
    if firmware.state is not State.TRACK:
        raise HysgenError(f"{controller.name}: the image does not start: {firmware.state!r}, {firmware.status!r}")
    # The board needs y_d of the sample that the inverse computes a voltage for, `ahead` samples later.
    ahead = preview(model.blocks) + 1
    wanted_um = np.concatenate([reference_um[ahead:], np.full(ahead, reference_um[-1])])
    pieces = np.array_split(wanted_um, max(1, round(seconds)))
    logs = []
    for i, piece in enumerate(pieces):
        progress(i / len(pieces), f"{controller.name}, {f_Hz:g} Hz")
        logs.append(firmware.run(piece))
    reading_um = np.concatenate([log.reading_um for log in logs]).astype(np.float64)
    output_V = np.concatenate([log.output_V for log in logs]).astype(np.float64)
    return TrackingResult(
        controller.name,
        f_Hz,
        **_errors_nm(reading_um, reference_um),
        voltage_V=_range_V(output_V),
        commits=int(firmware.firmware.commits),
        status=str(firmware.status),
    )


def _proportional(f_Hz: float, seconds: float) -> TrackingResult:
    """Track one frequency by u = K (y_d - c), fitted to the record of `extended`, without firmware."""
    drive_V = extended_drive()
    line = fit_proportional(measured(drive_V))
    reference_um = _reference(f_Hz, seconds)
    u_V = line.inverse(reference_um)
    state = at_rest(drive_V)
    lead_V: Floats = np.concatenate([np.linspace(0.0, float(u_V[0]), 5000), np.full(5000, u_V[0])])
    state.advance(lead_V, np.zeros((lead_V.size, 0)))
    trace = state.advance(u_V, np.zeros((u_V.size, 0)))
    errors_nm = _errors_nm(trace.reading_um, reference_um)
    return TrackingResult("proportional", f_Hz, **errors_nm, voltage_V=_range_V(u_V), commits=0, status="")


def _errors_nm(reading_um: Floats, reference_um: Floats) -> dict[str, float]:
    """The errors of a TrackingResult by name, from the end of the rest on."""
    error_nm = 1e3 * (reading_um - reference_um)[round(REST_S / TS_S) :]
    last_nm = error_nm[-round(1.0 / TS_S) :]
    return {
        "rms_nm": float(np.sqrt(np.mean(error_nm**2))),
        "mean_nm": float(error_nm.mean()),
        "spread_nm": float(error_nm.std()),
        "last_nm": float(np.sqrt(np.mean(last_nm**2))),
    }


def _range_V(u_V: Floats) -> tuple[float, float]:
    """Lowest and highest voltage from the end of the rest on."""
    scored_V = u_V[round(REST_S / TS_S) :]
    return float(scored_V.min()), float(scored_V.max())
