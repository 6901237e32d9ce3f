"""Other instruction sets under qemu: the same bits, also where the compiler is told to fuse multiply and add."""

import dataclasses
from pathlib import Path

import pytest

from fixtures.guards import unguarded_against_fusing
from fixtures.proof_models import model, texts
from fixtures.tools import need
from hysgen.checking import Host
from hysgen.checking.bits.learning_run import LEAST_UPDATES, HostSide, compare_learning
from hysgen.checking.proof.emulated import PLATFORMS, Emulated, EmulationSettings, Platform, equality
from hysgen.cli import main
from hysgen.codegen.manifest import write
from hysgen.errors import BuildError

# `hysgen verify DIR --target emulated --samples 1000000` makes the long run; its table is in docs/target.md.
SAMPLES = 4000


def need_platforms() -> None:
    for platform in PLATFORMS:
        need(*platform.commands)


def platform(name: str) -> Platform:
    (found,) = [platform for platform in PLATFORMS if platform.name == name]
    return found


@pytest.mark.slow
def test_five_instruction_sets_give_the_bits_of_the_reference() -> None:
    """Every term, block and the learner; those of the paper's model are in the test of the guard against fusing."""
    need_platforms()
    name = "small_everything"
    report = equality(model(name), texts(name), EmulationSettings(SAMPLES))
    assert report.equal, "\n".join(report.lines())
    assert len(report.comparison.builds) == 5
    assert not report.comparison.skipped
    compared = {run.function for run in report.comparison.runs}
    assert compared >= {"init", "predict", "simulate", "inverse", "selftest"}
    assert ("learn" in compared) == (model(name).learner is not None)
    if model(name).learner is not None:
        # In the learning run the active bank changes in each platform's own memory, with the host's bits.
        here, *there = report.learning
        assert len(there) == 5
        assert here.switches == here.committed >= 1
        assert all(row.equal and row.switches == row.committed == here.committed for row in there)
    assert all(run.builds == 6 for run in report.comparison.runs)


@pytest.mark.slow
def test_an_instruction_set_of_the_other_byte_order_gives_the_bits_of_the_model_that_ships() -> None:
    need("s390x-linux-gnu-gcc", "qemu-s390x-static")
    report = equality(model("extended"), texts("extended"), EmulationSettings(SAMPLES, [platform("s390x")]))
    assert report.equal, "\n".join(report.lines())
    here, there = report.learning
    assert there.equal
    assert there.switches == there.committed == here.committed


class Stuck(HostSide):
    """A platform on which the bank in use never changes."""

    def commit(self) -> int:
        words, active = self.host.words_of(self._instance), self.host.layout(f"{self.host.name}_t")["active"]
        before = int(words[active])
        answer = super().commit()
        words[active] = before
        return answer


@pytest.mark.slow
def test_a_machine_on_which_no_bank_changes_is_seen() -> None:
    host = Host("learning", texts("learning"))
    sides = [HostSide("here", host), HostSide("there", host), Stuck("stuck", host)]
    here, there, stuck = compare_learning(model("learning"), sides, host, LEAST_UPDATES)
    assert here.switches == here.committed >= 1
    assert there.equal
    assert (stuck.equal, stuck.switches, stuck.committed) == (False, 0, here.committed)
    assert "DIFFERENT, first: call" in str(stuck)


def test_a_learner_that_differs_from_the_reference_on_every_machine_is_seen() -> None:
    wrong = {file: text.replace("LEARNING_LEARN_FAST * away", "away") for file, text in texts("learning").items()}
    assert wrong != texts("learning")
    host = Host("learning", wrong)
    here, there = compare_learning(
        model("learning"), [HostSide("here", host), HostSide("there", host)], host, LEAST_UPDATES
    )
    assert there.equal
    assert not here.equal
    assert "of the reference" in (here.first or "")


@pytest.mark.slow
def test_one_bit_of_one_constant_is_seen_on_the_machine_that_has_it() -> None:
    need("s390x-linux-gnu-gcc", "qemu-s390x-static")
    # A big-endian platform whose C has another last bit in one coefficient of the exponential.
    wrong = {file: text.replace("0.240226477f", "0.240226492f") for file, text in texts("appendix_a").items()}
    assert wrong != texts("appendix_a")
    program = Emulated("appendix_a", wrong, platform("s390x"))
    assert program.call("selftest") > 0
    report = equality(model("appendix_a"), wrong, EmulationSettings(2000, [platform("s390x")]))
    assert not report.equal
    assert any("s390x" in mismatch.build for mismatch in report.comparison.mismatches)


def test_words_in_the_other_order_of_bytes_would_be_seen() -> None:
    need("powerpc-linux-gnu-gcc", "qemu-ppc-static")
    mistaken = dataclasses.replace(platform("powerpc"), order="<")
    with pytest.raises(BuildError, match="the program ended"):
        equality(model("appendix_a"), texts("appendix_a"), EmulationSettings(100, [mistaken]))


@pytest.mark.slow
def test_the_guard_forbids_fusing_and_without_it_bits_and_self_test_tell() -> None:
    need_platforms()
    vfp = dataclasses.replace(PLATFORMS[0], flags=(*PLATFORMS[0].flags, "-mfpu=neon-vfpv4"))
    fusing = EmulationSettings(SAMPLES, [vfp, *PLATFORMS[1:]], ("-O2", "-ffp-contract=fast"))
    assert equality(model("appendix_a"), texts("appendix_a"), fusing).equal
    bare = unguarded_against_fusing(texts("appendix_a"), "appendix_a")
    wrong = equality(model("appendix_a"), bare, fusing).comparison.mismatches
    for function in ("predict", "selftest"):
        assert len({m.build for m in wrong if m.function == function}) == len(PLATFORMS)


def test_a_missing_compiler_is_told_with_its_packages() -> None:
    absent = dataclasses.replace(platform("armhf"), compiler="arm-nowhere-gcc", emulator="")
    with pytest.raises(BuildError, match=r"arm-nowhere-gcc not installed; apt-get install gcc-arm-linux-gnueabihf"):
        Emulated("appendix_a", texts("appendix_a"), absent)

    installed = [platform for platform in PLATFORMS if not platform.missing]
    if not installed:
        need(*PLATFORMS[0].commands)
    report = equality(model("appendix_a"), texts("appendix_a"), EmulationSettings(100, [absent, *installed[:1]]))
    assert report.comparison.skipped == (
        "armhf: arm-nowhere-gcc not installed; "
        "apt-get install gcc-arm-linux-gnueabihf libc6-dev-armhf-cross qemu-user-static",
    )


@pytest.mark.slow
def test_the_verb_runs_one_machine_and_refuses_one_without_its_target(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need("s390x-linux-gnu-gcc", "qemu-s390x-static")
    write(texts("appendix_b"), tmp_path)
    call = ["verify", str(tmp_path), "--machine", "s390x", "--samples", "500"]
    assert main([*call, "--target", "emulated"]) == 0
    said = capsys.readouterr().out
    assert "s390x: s390x-linux-gnu-gcc" in said
    assert "appendix_b: equal in every bit" in said
    assert main(call) == 2
    assert "add it" in capsys.readouterr().err
