"""verify: bits of generated C against its reference; prove: warnings, MISRA rules, sanitizers, proofs."""

import argparse
from pathlib import Path

from hysgen.api.code import Generated, prove, verify
from hysgen.checking.bits.comparison import DEFAULT_SAMPLES
from hysgen.checking.bits.functions import LEARNING_SHARE
from hysgen.checking.proof import CHECKS, Checked, CheckSettings, Proof, known_checks
from hysgen.checking.proof.emulated import PLATFORMS
from hysgen.cli.console import Console
from hysgen.cli.options import add_folder
from hysgen.cli.verbs import Verb
from hysgen.codegen.manifest import read_folder
from hysgen.errors import HysgenError
from hysgen.targets import Extent, named, target, targets
from hysgen.targets.emulated import SAMPLES as EMULATED_SAMPLES

VERIFY_HELP = """\
Prove that generated C equals its NumPy reference, bit for bit.

Every compiler and optimisation level that is installed is compared, with and without flushing denormal numbers to zero,
over random, edge and long-run inputs. With --target the C runs elsewhere: on the simulated C674x, or under qemu on
other processors, both orders of bytes.
"""
PROVE_HELP = """\
Show of generated C, without running it on the target, what can be shown: warnings, MISRA rules, sanitizers, proofs.

warnings: gcc and clang under one wall of flags. misra: cppcheck's add-on; every finding of a required rule is red.
sanitize: the C runs under gcc's sanitizers on every kind of input. equal: the C computes the bits of the reference for
every input, function by function, and scheduled kernels those of the C (with the solver of `pip install
'hysgen[prove]'`). eva: Frama-C proves, for every input and every state inside the certified box, that nothing fails,
that no float becomes infinite or NaN, and that the state is then inside the box again. docs/proof.md says what is
assumed.
"""

TARGET_SAMPLES = 4000


def verify_arguments(parser: argparse.ArgumentParser) -> None:
    add_folder(parser)
    parser.add_argument(
        "--samples",
        type=int,
        default=None,
        help=f"in each build (default {DEFAULT_SAMPLES}); with --target, of each function (default {TARGET_SAMPLES} on "
        f"the c674x, {EMULATED_SAMPLES} emulated, there {LEARNING_SHARE:g} of them for learning)",
    )
    parser.add_argument(
        "--updates",
        type=int,
        default=None,
        metavar="N",
        help="with --target c674x: chained updates of the learner, with commits, on simulator, host and reference "
        f"(default {LEARNING_SHARE:g} of the samples)",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the inputs (default %(default)s)")
    parser.add_argument(
        "--prove", action="store_true", help="also prove equality for every input, as `hysgen prove --only equal` does"
    )
    parser.add_argument(
        "--target",
        type=lambda name: target(name, "verify"),
        metavar="{" + ",".join(named("verify")) + "}",
        help="; ".join(f"{name}: {targets()[name].about}" for name in named("verify")),
    )
    parser.add_argument(
        "--machine",
        choices=[platform.name for platform in PLATFORMS],
        action="append",
        help="with --target emulated: this processor only (may be repeated)",
    )


def run_verify(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.prove and arguments.target:
        raise HysgenError("--prove: belongs to verify without --target; leave one of them out")
    given = {"updates": arguments.updates is not None, "machines": bool(arguments.machine)}
    for option in (name for name, used in given.items() if used):
        if arguments.target is None or option not in arguments.target.verify_options:
            owners = [name for name in named("verify") if option in targets()[name].verify_options]
            flag = f"--{option.removesuffix('s') if option == 'machines' else option}"
            raise HysgenError(f"{flag} belongs to --target {' or '.join(owners) or 'NAME'}; add it")
    if arguments.target:
        return run_on_target(arguments, console)
    samples = DEFAULT_SAMPLES if arguments.samples is None else arguments.samples
    report = verify(Path(arguments.folder), samples, console.progress, arguments.seed)
    console.say("\n".join(report.lines()))
    if not arguments.prove:
        return console.finish(report.to_json(), report.equal)
    proof = prove(Path(arguments.folder), ["equal"], progress=console.progress)
    for check in proof.checks.values():
        console.say("\n".join(check.answer.lines()))
    answers = {name: check.answer.to_json() for name, check in proof.checks.items()}
    answer = {**report.to_json(), "proof": answers.pop("equal"), **answers}
    return console.finish(answer, report.equal and proof.clean)


def run_on_target(arguments: argparse.Namespace, console: Console) -> int:
    """Compare the bits of the C on the target with those here."""
    generated = read_folder(Path(arguments.folder))
    extent = Extent(arguments.samples, arguments.seed, arguments.updates, tuple(arguments.machine or ()))
    report = arguments.target.verify(generated.model, generated.texts, extent, console.progress)
    console.say("\n".join(report.lines()))
    return console.finish(report.to_json(), report.equal)


def prove_arguments(parser: argparse.ArgumentParser) -> None:
    add_folder(parser)
    parser.add_argument(
        "--only", default=",".join(CHECKS), metavar="CHECKS", help="some of them, with commas (default %(default)s)"
    )
    parser.add_argument("--samples", type=int, default=100_000, help="sanitize: of each function (default %(default)s)")
    parser.add_argument(
        "--calls", default="", metavar="CALLS", help="equal, eva: functions to prove, with commas (default all)"
    )


def run_prove(arguments: argparse.Namespace, console: Console) -> int:
    names = known_checks(arguments.only.split(","))
    folder = read_folder(Path(arguments.folder))
    for line in folder.altered:
        console.warn(line)
    calls = tuple(function for function in arguments.calls.split(",") if function)
    settings = CheckSettings(arguments.samples, calls)
    checks: dict[str, Checked] = {}
    for name in names:
        made = prove(Generated(folder.model, folder.texts), [name], settings, console.progress).checks
        for kind, check in made.items():
            console.say("\n".join([f"{kind}:", *check.answer.lines()]) + "\n")
        checks |= made
    proof = Proof(folder.model.name, checks)
    return console.finish({**proof.to_json(), "altered": list(folder.altered)}, proof.clean)


VERBS = {
    "verify": Verb(VERIFY_HELP, verify_arguments, run_verify),
    "prove": Verb(PROVE_HELP, prove_arguments, run_prove),
}
