"""Relaxation is named on hysterons that thermal activation switches, and not on a Preisach operator."""

from __future__ import annotations

import pytest

from hysgen.diagnosis.causes.relaxation import RelaxationPart
from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Scene
from hysgen.diagnosis.score import present
from hysgen.diagnosis.search import search
from hysgen.machine.threads import one_blas_thread
from hysgen_lab.studies.bank.family_scenario import family_scenario


def seen(family: str) -> Scene:
    hidden = family_scenario(family, "memory", 3)
    return prepare(hidden.record(hidden.measure())).excerpt()


@pytest.mark.parametrize(("family", "relaxes"), [("thermal", True), ("preisach", False)])
@pytest.mark.slow
def test_relaxation_is_named_if_the_hysteresis_depends_on_time(family: str, relaxes: bool) -> None:
    with one_blas_thread():
        found = search(seen(family))
    assert ("relaxation" in present(found.fit.chain)) == relaxes
    if relaxes:
        assert found.error_growth["relaxation"] > 1.2
        assert 0.01 < found.fit.chain.of(RelaxationPart).half_widths < 0.06
