"""The generated C on the simulated C674x: the host's bits, in cycles that do not depend on the data."""

import functools
from collections.abc import Sequence

import numpy as np
import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.proof_models import model, texts
from hysgen.checking import Host
from hysgen.checking.bits.learning_run import LEAST_UPDATES, HostSide, compare_learning
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import bounds, c_texts, cycle_bounds
from hysgen_c674x.equality import SimulatedSide, verify_on_target

pytestmark = pytest.mark.slow

SAMPLES = 400


def test_every_function_has_the_hosts_bits_and_constant_cycles() -> None:
    need_compiler()
    plain, generated_c = model("appendix_a"), texts("appendix_a")
    report = verify_on_target(plain, generated_c, SAMPLES)
    assert report.equal
    assert {run.function for run in report.runs} == {"predict", "simulate", "inverse", "limits"}
    assert all(run.words > 40 for run in report.runs)
    # What the static bound says is what every call took, whatever the data: random, edges, or any 32 bits.
    bounds = cycle_bounds(plain.name, generated_c)
    for run in report.runs:
        assert run.cycles == (bounds[run.function].best, bounds[run.function].worst)
    assert all(bound.constant for bound in bounds.values())


@functools.cache
def compiled(name: str) -> toolchain.Firmware:
    """One of the models for proofs, for the target."""
    need_compiler()
    return toolchain.compile(c_texts(texts(name)))


def test_a_learner_has_the_hosts_bits_on_inputs_of_every_style(monkeypatch: pytest.MonkeyPatch) -> None:
    firmware = compiled("learning")
    monkeypatch.setattr(toolchain, "compile", lambda sources: firmware)
    report = verify_on_target(model("learning"), texts("learning"), SAMPLES)
    assert report.equal, report.notes()
    assert {run.function for run in report.runs} == {"predict", "simulate", "inverse", "limits", "learn", "commit"}
    assert report.committed
    assert report.reference == "equal in every bit"
    assert f"shadows that became active: {report.committed}, refused: {report.refused}" in report.notes()


class Stuck(SimulatedSide):
    """A target on which the bank in use never changes."""

    name = "stuck"

    def commit(self) -> int:
        active = self._machine.view(self._instance, 1, np.uint32)
        before = int(active[0])
        answer = super().commit()
        active[0] = before
        return answer


@pytest.mark.parametrize("name", ["learning", pytest.param("everything", marks=pytest.mark.proof)])
def test_banks_change_on_the_target_in_the_hosts_bits_and_within_the_bounds(name: str) -> None:
    learner, host, firmware = model(name), Host(name, texts(name)), compiled(name)
    assert host.layout(f"{name}_t")["active"] == 0
    side, stuck = SimulatedSide(host, firmware.machine()), Stuck(host, firmware.machine())
    here, there, wrong = compare_learning(learner, [HostSide("here", host), side, stuck], host, LEAST_UPDATES)
    assert (there.learnt_wrong, there.committed_wrong) == (0, 0), there.first
    assert there.samples == LEAST_UPDATES
    # The bank in use changed in the target's own memory each time that commit said so; the predictions behind it agree.
    assert there.switches == there.committed == here.switches >= 1
    assert (wrong.switches, wrong.committed_wrong > 0, wrong.first is None) == (0, True, False)
    found = firmware.packets
    for function, spent in {"learn": side.learning, "commit": side.committing}.items():
        bound = bounds(firmware.image, found, f"{name}_{function}")
        assert bound.best <= spent.least <= spent.most <= bound.worst


def test_one_bit_of_one_constant_is_seen_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    need_compiler()
    honest = toolchain.compile

    def altered(sources: Sequence[tuple[str, str]], flags: Sequence[str] = ()) -> toolchain.Firmware:
        wrong = [(name, text.replace("0.240226477f", "0.240226492f")) for name, text in sources]
        assert wrong != list(sources)
        return honest(wrong, flags)

    monkeypatch.setattr(toolchain, "compile", altered)
    report = verify_on_target(model("appendix_a"), texts("appendix_a"), SAMPLES)
    assert not report.equal
    assert any("DIFFERENT" in note and "the host's is 0x" in note for note in report.notes())
