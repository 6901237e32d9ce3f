"""A stage that moves against its input after every turn is predicted by a hysteresis that need not rise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.api.code import generate
from hysgen.api.diagnosing import diagnose
from hysgen.codegen import Options
from hysgen.diagnosis import DiagnoseSettings
from hysgen.errors import CertificateError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen_lab.studies.bank.excitation import good

TS_S, NOISE_UM = 1e-3, 2e-3
SIZE = PathSize(plays=16)


def against(u_V: NDArray[np.float64]) -> Record:
    """0.12 u + 2 atan(s / 6 V), s: voltage since the last turn, falling as it rises; slope 0.12 - 0.33 um/V there.

    Madelung's first rule alone: the branch from a turn depends on the turn, not on what was before it.
    """
    s_V = np.zeros(len(u_V))
    for k in range(1, len(u_V)):
        du_V = u_V[k] - u_V[k - 1]
        s_V[k] = s_V[k - 1] + du_V if du_V * s_V[k - 1] >= 0.0 else du_V
    noise_um = NOISE_UM * np.random.default_rng(5).standard_normal(len(u_V))
    return Record.from_arrays(u_V, 0.12 * u_V - 2.0 * np.arctan(s_V / 6.0) + noise_um, TS_S)


@pytest.fixture(scope="module")
def record() -> Record:
    return against(good(np.random.default_rng(11), 6000, 0.0, 100.0))


def left_um(record: Record, settings: FitSettings) -> float:
    """rms of the free run in um over the rows that the fit has not seen."""
    known, later = record.split(0.65)
    return float(np.sqrt(np.mean((free_run(fit(known, settings), later)[0].y_um - later.segments[0].y_um) ** 2)))


def test_a_hysteresis_that_may_fall_predicts_what_a_rising_one_cannot(record: Record) -> None:
    rising_um = left_um(record, FitSettings(memory=SIZE))
    falling_um = left_um(record, FitSettings(memory=SIZE, rising=False))
    assert falling_um < 0.5 * rising_um, (falling_um, rising_um)


def test_its_c_has_no_inverse_and_an_inverse_that_is_asked_for_is_refused(record: Record) -> None:
    model = fit(record, FitSettings(name="against", memory=SIZE, rising=False))
    texts = generate(model).texts
    assert "against_predict" in texts["against.h"]
    assert "against_inverse" not in texts["against.h"]
    with pytest.raises(CertificateError, match="a voltage may not exist"):
        generate(model, Options(inverse=True))


@pytest.mark.slow
def test_the_answer_says_what_the_inverse_costs(record: Record) -> None:
    said = diagnose(record).diagnosis.remaining
    assert "--predict-only" in said.reason
    predicts = diagnose(record, settings=DiagnoseSettings(fit=FitSettings(rising=False))).diagnosis.remaining
    assert predicts.rms_um < 0.8 * said.rms_um
    assert "--predict-only" not in predicts.reason
