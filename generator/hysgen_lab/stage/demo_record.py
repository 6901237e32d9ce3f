"""The measurement behind the bundled record: the laboratory stage under a command that excites all that it does.

`python -m hysgen_lab.stage.demo_record FILE` writes it again.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.files import write_whole
from hysgen_lab.stage.description import Stage
from hysgen_lab.stage.measure import Measurement, run
from hysgen_lab.stage.signals import nested_amplitudes, plateaus

Floats = NDArray[np.float64]
Trains = tuple[tuple[float, int], ...]

TS_S = 20e-6  # the paper's 50 kHz
SEED = 2012
REST_V = 30.0
# Half peak-to-peak of the loops in V, and (frequency in Hz, periods) of their falling and growing trains.
IDENTIFY_V, IDENTIFY_TRAINS = 25.0, ((100.0, 8), (50.0, 6), (25.0, 4))
VALIDATE_V, VALIDATE_TRAINS = 21.0, ((70.0, 5), (40.0, 3))
IDENTIFY_LEVELS_V = (30.0, 52.0, 14.0, 41.0, 23.0, 30.0)
VALIDATE_LEVELS_V = (30.0, 18.0, 47.0, 30.0)
HOLD_S, TRAVEL_S = 0.030, 0.004


def identification_rows() -> int:
    """Rows of the bundled record that are for identification; validation begins at this row, counted from 0."""
    return len(_drive(IDENTIFY_V, IDENTIFY_TRAINS, IDENTIFY_LEVELS_V))


def demo_measurement() -> Measurement:
    """The bundled record with its truth: 50 kHz, identification part, then validation with other loops and levels.

    Each part: sines at several frequencies whose amplitude falls to nothing and grows again, then plateaus, all about
    30 V. Seeded: the same on every machine.
    """
    parts = (
        _drive(IDENTIFY_V, IDENTIFY_TRAINS, IDENTIFY_LEVELS_V),
        _drive(VALIDATE_V, VALIDATE_TRAINS, VALIDATE_LEVELS_V),
    )
    # The stage is driven with the decimals of the file.
    u_V: Floats = np.asarray(np.round(np.concatenate(parts), 5), dtype=np.float64)
    return run(Stage.laboratory(), u_V, TS_S, SEED)


def demo_csv() -> str:
    """The bundled record as text: time_s, voltage_V, displacement_um."""
    record = demo_measurement()
    rows = zip(record.time_s, record.voltage_V, record.displacement_um, strict=True)
    lines = (f"{t_s:.6f},{u_V:.5f},{y_um:.4f}" for t_s, u_V, y_um in rows)
    return "\n".join(("time_s,voltage_V,displacement_um", *lines, ""))


def _drive(amplitude_V: float, trains: Trains, levels_V: tuple[float, ...]) -> Floats:
    """Trains of nested loops, then plateaus: from REST_V and back to it."""
    loops = [nested_amplitudes(TS_S, (f_Hz,), REST_V, amplitude_V, periods) for f_Hz, periods in trains]
    return np.concatenate([*loops, plateaus(TS_S, levels_V, HOLD_S, TRAVEL_S)])


if __name__ == "__main__":
    write_whole(Path(sys.argv[1]), demo_csv())
