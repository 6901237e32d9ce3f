"""The bundled record is what its function makes, and it can be read by eye."""

from __future__ import annotations

import numpy as np

from hysgen.record.bundled import bundled_csv
from hysgen_lab.stage.demo_record import TS_S, demo_csv, demo_measurement, identification_rows


def test_the_bundled_record_is_what_the_stage_makes() -> None:
    assert bundled_csv() == demo_csv()


def test_the_bundled_record_reads_back_exactly() -> None:
    text = bundled_csv()
    assert len(text.encode()) < 2_000_000
    assert text.startswith("time_s,voltage_V,displacement_um\n0.000000,30.00000,")
    time_s, voltage_V, displacement_um = np.array([line.split(",") for line in text.splitlines()[1:]], dtype=float).T
    made = demo_measurement()
    assert (voltage_V == made.voltage_V).all()
    # Four decimals hold the sensor's steps of 0.5 nm whole, six the sampling instants.
    np.testing.assert_allclose(displacement_um, made.displacement_um, atol=1e-12)
    np.testing.assert_allclose(time_s, TS_S * np.arange(len(time_s)), atol=1e-12)


def test_validation_stays_inside_what_identification_visited_and_drives_otherwise() -> None:
    record, split = demo_measurement(), identification_rows()
    for values in (record.voltage_V, record.displacement_um):
        assert values[:split].min() < values[split:].min()
        assert values[split:].max() < values[:split].max()
    assert record.voltage_V[0] == record.voltage_V[split] == record.voltage_V[-1] == 30.0
    assert len(np.intersect1d(record.voltage_V[:split], record.voltage_V[split:])) < 0.01 * split
