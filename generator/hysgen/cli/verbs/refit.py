"""Identify a model again from a new record: same structure, new numbers.

With --c the C in DIR is generated again and compared with its reference; the files that changed are listed.
Exit code 1 says that the structure no longer fits (the new model simulates its own record worse than the old one did
its own by more than half, and not for noise), or that the C differs from its reference. If the structure does not fit,
the record is diagnosed, and nothing is written unless --anyway is given.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from pathlib import Path
from typing import Any

from hysgen.certify.certificates import certify
from hysgen.checking.bits import verify
from hysgen.cli.console import Console
from hysgen.cli.records import add_record_options, read_records
from hysgen.cli.verbs.diff import comparison_text
from hysgen.codegen import Options, generate, write
from hysgen.codegen.freshness import stale
from hysgen.codegen.manifest import MANIFEST, read_folder
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import diagnose_and_evaluate
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings
from hysgen.fitting.compare import compare
from hysgen.fitting.refit import refit, restricted_as, structure_fits
from hysgen.model.file import load_model, save_model
from hysgen.model.model import Model
from hysgen.record import Record
from hysgen.report.words import price_of, verdict

VERIFIED_SAMPLES = 200_000


def arguments(parser: argparse.ArgumentParser) -> None:
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


def run(arguments: argparse.Namespace, console: Console) -> int:
    started = time.monotonic()
    old = load_model(arguments.model)
    record = read_records(arguments.records, arguments, console)
    new, scores = refit(old, record, console.progress, same_range=arguments.same_range)
    comparison = compare(old, new, [record])
    fits, why = structure_fits(old, scores)
    console.say(scores.table())
    console.say("\n" + comparison_text(comparison) + "\n")
    result: dict[str, Any] = {
        "structure_fits": fits,
        "why": why,
        "scores": scores.to_json(),
        "comparison": comparison.to_json(),
    }
    console.say(f"structure: {why}")
    good = fits
    if not fits and not arguments.no_diagnosis:
        result["diagnosis"] = explain(old, record, console)
    if fits or arguments.anyway:
        save_model(new, Path(arguments.output))
        console.say(f"written: {arguments.output}")
        if arguments.c:
            result["c"] = regenerate(new, Path(arguments.c), console)
            good = good and result["c"]["equal"]
    else:
        console.say("nothing is written (--anyway writes the model all the same)")
    result["seconds"] = round(time.monotonic() - started, 1)
    console.say(f"{result['seconds']} s from record to {'verified C' if 'c' in result else 'answer'}")
    console.write_json(result)
    return 0 if good else 1


def explain(old: Model, record: Record, console: Console) -> dict[str, Any]:
    """What the diagnosis of the new record finds, and what of it the old structure lacks."""
    settings = DiagnoseSettings(fit=FitSettings(name=old.name, rules=old.grid.rules), price=price_of)
    try:
        found = diagnose_and_evaluate(record, settings=settings, progress=console.progress)
    except HysgenError as fault:
        console.say(f"diagnosis: {fault}")
        return {"error": str(fault)}
    had = {*(term.kind for term in old.terms), *(block.kind for block in old.blocks)}
    lacking = [name for name in found.diagnosis.names if name not in had]
    console.say("\ndiagnosis of the new record\n" + "\n".join(verdict(found)))
    console.say(
        f"the model does not have: {', '.join(lacking)}; hysgen diagnose -o writes a model that has"
        if lacking
        else "the model has a part for each of these causes, but with other shapes; hysgen diagnose -o finds them again"
    )
    return found.diagnosis.to_json() | {"lacking": lacking}


def as_before(model: Model, folder: Path) -> tuple[Model, Options]:
    """The model with the learner and the ranges, and the options, that the folder was generated with, if it was."""
    if not (folder / MANIFEST).exists():
        return model, Options(inverse=certify(model).inverse_holds)
    before = read_folder(folder)
    if before.model.name != model.name:
        raise HysgenError(f"{folder}: holds the C of {before.model.name}, not of {model.name}; name another folder")
    told = before.facts.get("options", {})
    clock_Hz = float(told.get("clock_Hz", Options().clock_Hz))
    model = restricted_as(before.model, dataclasses.replace(model, learner=before.model.learner))
    return model, Options(bool(told.get("inverse")), clock_Hz)


def regenerate(model: Model, folder: Path, console: Console) -> dict[str, Any]:
    """The C of the new model in its folder: which files changed, and whether it equals its reference."""
    texts = generate(*as_before(model, folder))
    changed = [item.name for item in stale(texts, folder)]
    write(texts, folder)
    console.say(f"changed in {folder}: {', '.join(changed) or 'nothing'}; as before: {len(texts) - len(changed)} files")
    report = verify(folder, samples=VERIFIED_SAMPLES, structures=0, progress=console.progress)
    console.say(report.lines()[-1])
    return {"changed": changed, "equal": report.equal, "samples": report.samples}
