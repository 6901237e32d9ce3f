"""refit, diff: a model identified again from a new record, and what moved from one model to another."""

import argparse
import time
from pathlib import Path
from typing import Any

from hysgen.api.code import generate_again, verify
from hysgen.api.diagnosing import diagnose
from hysgen.cli.console import Console
from hysgen.cli.options import add_record_options, read_records
from hysgen.cli.verbs import Output, Verb
from hysgen.codegen.manifest import stale
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.causes import causes
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings
from hysgen.fitting.refit import compare, loop_line, refit, structure_fits
from hysgen.model.file import load_model, save_model
from hysgen.model.model import Model
from hysgen.record import Record
from hysgen.report.words import verdict

REFIT_HELP = """\
Identify a model again from a new record: same structure, new numbers.

With --c the C in DIR is generated again and compared with its reference; the files that changed are listed.
Exit code 1 says that the structure no longer fits (the new model simulates its own record worse than the old one did
its own by more than half, and not for noise), or that the C differs from its reference. If the structure does not fit,
the record is diagnosed, and nothing is written unless --anyway is given.
"""
DIFF_HELP = """\
Say what moved from one model to another of the same structure, in physical terms and rule by rule."""

REFIT_EXAMPLES = ("hysgen refit stage.json later.csv -o stage2.json --c firmware/stage",)

VERIFIED_SAMPLES = 200_000


def refit_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL")
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("-o", "--output", required=True, metavar="MODEL", help="model file to write")
    parser.add_argument("--c", metavar="DIR", help="generate the C in DIR again, and verify it")
    parser.add_argument(
        "--same-range", action="store_true", help="keep the displacement range, as a parameter image for firmware needs"
    )
    parser.add_argument("--anyway", action="store_true", help="write even if the structure no longer fits")
    parser.add_argument("--no-diagnosis", action="store_true", help="do not diagnose if the structure no longer fits")
    add_record_options(parser)


def run_refit(arguments: argparse.Namespace, console: Console) -> int:
    started = time.monotonic()
    old = load_model(arguments.model)
    record = read_records(arguments.records, arguments, console)
    new, scores = refit(old, record, console.progress, same_range=arguments.same_range)
    comparison = compare(old, new, [record])
    fits, why = structure_fits(old, scores)
    console.say(scores.table())
    console.say("\n" + comparison.text() + "\n")
    result: dict[str, Any] = {
        "structure_fits": fits,
        "why": why,
        "scores": scores.to_json(),
        "comparison": comparison.to_json(),
    }
    console.say(f"structure: {why}")
    if line := loop_line(old, new):
        (console.say if new.feedback else console.warn)(line)
    good = fits
    if not fits and not arguments.no_diagnosis:
        result["diagnosis"] = explain(old, record, console)
    if fits or arguments.anyway:
        save_model(new, Path(arguments.output))
        console.say(f"written: {arguments.output}")
        if arguments.c:
            result["c"] = regenerate(new, Path(arguments.c), console, arguments.force)
            good = good and result["c"]["equal"]
    else:
        console.say("nothing is written (--anyway writes the model all the same)")
    result["seconds"] = round(time.monotonic() - started, 1)
    console.say(f"{result['seconds']} s from record to {'verified C' if 'c' in result else 'answer'}")
    return console.finish(result, good)


def explain(old: Model, record: Record, console: Console) -> dict[str, Any]:
    """Diagnose the new record and list the causes that the old model has no part for. Returns the diagnosis as JSON."""
    settings = DiagnoseSettings(fit=FitSettings(name=old.name, rules=old.grid.rules))
    try:
        study = diagnose(record, settings=settings, progress=console.progress)
    except HysgenError as fault:
        console.say(f"diagnosis: {fault}")
        return {"error": str(fault)}
    present = {*(term.kind for term in old.terms), *(block.kind for block in old.blocks)}
    kinds = {name: cause.kind or name for name, cause in causes().items()}
    lacking = [name for name in study.diagnosis.names if kinds.get(name, name) not in present]
    console.say("\ndiagnosis of the new record\n" + "\n".join(verdict(study)))
    console.say(
        f"the model does not have: {', '.join(lacking)}; hysgen diagnose -o writes a model that has"
        if lacking
        else "the model has a part for each of these causes, but with other shapes; hysgen diagnose -o finds them again"
    )
    return study.diagnosis.to_json() | {"lacking": lacking}


def regenerate(model: Model, folder: Path, console: Console, force: bool) -> dict[str, Any]:
    """Write the C of the new model into its folder and compare it with its reference. Returns the result as JSON."""
    code = generate_again(model, folder, force)
    for line in code.warnings:
        console.warn(line)
    changed = [item.name for item in stale(code.texts, folder)]
    code.write(folder)
    same = len(code.texts) - len(changed)
    console.say(f"changed in {folder}: {', '.join(changed) or 'nothing'}; as before: {same} files")
    report = verify(folder, VERIFIED_SAMPLES, console.progress)
    console.say(report.lines()[-1])
    return {"changed": changed, "equal": report.equal, "samples": report.samples}


def diff_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("old", metavar="OLD")
    parser.add_argument("new", metavar="NEW")
    parser.add_argument(
        "--records", nargs="+", metavar="RECORD", default=[], help="score both models in free run on these"
    )
    add_record_options(parser)


def run_diff(arguments: argparse.Namespace, console: Console) -> int:
    records = [read_records([path], arguments, console) for path in arguments.records]
    comparison = compare(load_model(arguments.old), load_model(arguments.new), records)
    console.say(comparison.text(f"{Path(arguments.old).name} -> {Path(arguments.new).name}"))
    return console.finish(comparison.to_json())


VERBS = {
    "refit": Verb(REFIT_HELP, refit_arguments, run_refit, {"output": Output("-o")}, REFIT_EXAMPLES),
    "diff": Verb(DIFF_HELP, diff_arguments, run_diff),
}
