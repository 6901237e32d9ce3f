"""Studies on the virtual stage: the paper's experiments, the bank of hidden effects, endurance.

track: the complete firmware on the virtual stage; gallery: pictures of each cause.
"""

import argparse
import dataclasses
import os
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.verbs import Output, Verb
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.machine.files import write_whole
from hysgen_lab.firmware.tracking import PAPER_NM, SECONDS, TrackingResult, track
from hysgen_lab.stage.families import FAMILIES
from hysgen_lab.studies.bank import CATEGORIES, OWN, Judgement, limits, limits_table
from hysgen_lab.studies.bank import run as judge_bank
from hysgen_lab.studies.endurance import ALLOWED_RATIO, CASES, HEADINGS, endurance_tests, rows
from hysgen_lab.studies.endurance import run as endure
from hysgen_lab.studies.gallery import gallery
from hysgen_lab.studies.paper.results import repeat_all

EXPERIMENTS_HELP = """\
Repeat the paper's experiments (sections 4.1 to 4.3, Fig. 11) on the virtual stage: a table and the figures.

Beyond the paper, the learner in generated C: held against Eq. (10) in float64, and after the plant has lost gain.
"""
BANK_HELP = """\
Hide effects in records of the virtual stage and count how often `diagnose` names them: confusion, limits, alarms.

With --family the stages have the hysteresis of other equations than the diagnosis, with a past that the record does not
show, other laws of creep, coloured and quantised noise, and a sensor with a curve.

Exit code 1 if a limit is missed; 130 if it was interrupted, after saying what it had until then. With --log, the same
command goes on where it was interrupted.
"""
ENDURANCE_HELP = """\
Run the generated learner for hours of samples of poor, broken and endless excitation, and test its recovery.

Every case drives the compiled learner of a model with six rules on the virtual stage. One second of persistent
excitation follows; the free-run error of the learned model is divided by that of a fresh fit to the same second. Eq.
(10) as printed runs in float32 over the same samples. Exit code 1 if a case fails.
"""

LEAST_SAMPLES = 1000
LEGEND = f"""\
holds:     factors finite, positive and bounded to the end, recovered to at most {ALLOWED_RATIO:g}
recovered: free-run error after one second of persistent excitation, divided by that of a fresh float64 fit to the
           same second with the same lambda; column `lambda 1`: divided by that of a fit without forgetting
Eq. (10):  as printed, in float32, on the same samples without NaN and spikes, which it does not reject"""


def experiments_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for the figures (PNG)")


def run_experiments(arguments: argparse.Namespace, console: Console) -> int:
    results = repeat_all(console.progress)
    console.say(results.text())
    if arguments.output:
        from hysgen.report import plots
        from hysgen_lab.studies.paper.results import modelling_figures, tracking_figure

        folder = Path(arguments.output)
        for outcome in results.modelling:
            for name, figure in modelling_figures(outcome).items():
                console.say(f"written: {plots.save(figure, folder / name)}")
        for tracked in results.tracking:
            path = folder / f"section-4.3-{tracked.f_Hz:g}-hz.png"
            console.say(f"written: {plots.save(tracking_figure(tracked), path)}")
    return console.finish(results.to_json())


def bank_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", default="1000:1010", metavar="A:B", help="seeds A to B, B excluded (%(default)s)")
    parser.add_argument("--categories", nargs="+", choices=CATEGORIES, default=list(CATEGORIES), metavar="NAME")
    parser.add_argument(
        "--family",
        nargs="+",
        choices=(*FAMILIES, "all"),
        metavar="NAME",
        help=f"stages of other equations than the diagnosis': {', '.join(FAMILIES)}, or all",
    )
    parser.add_argument("--log", metavar="FILE", help="one JSON line a record as it is judged; what it holds is kept")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")


def run_bank(arguments: argparse.Namespace, console: Console) -> int:
    judged = wrong = 0

    def report(fraction: float, judgement: Judgement) -> None:
        nonlocal judged, wrong
        judged, wrong = judged + 1, wrong + (not judgement.exact)
        name = judgement.name
        if judgement.category != "poor" and not judgement.exact:
            console.say(f"wrong: {name}: {judgement.difference()}")
        console.progress(
            fraction, f"{name}: {', '.join(judgement.named) or 'nothing'} ({judged} judged, {wrong} wrong)"
        )

    log = Path(arguments.log) if arguments.log else None
    named = arguments.family or [OWN]
    families = tuple(FAMILIES) if "all" in named else tuple(named)
    result = judge_bank(parse_seeds(arguments.seeds), arguments.categories, families, arguments.jobs, report, log)
    comparison = limits(result)
    console.say(result.table())
    console.say()
    console.say(limits_table(comparison))
    console.write_json(result.to_json() | {"limits": [dataclasses.asdict(limit) for limit in comparison]})
    if not result.complete:
        console.warn(f"interrupted: {len(result.judgements)} of {result.asked} records")
        return 130
    return int(any(limit.holds is False for limit in comparison))


def parse_seeds(text: str) -> range:
    """The seeds "A:B", B excluded. Raises HysgenError for any other text.

    >>> parse_seeds("1000:1003")
    range(1000, 1003)
    """
    first, _, last = text.partition(":")
    if not (first.isdecimal() and last.isdecimal() and int(first) < int(last)):
        raise HysgenError(f"seeds: '{text}' is not a range of whole numbers; write FIRST:LAST, as 1000:1010")
    return range(int(first), int(last))


def endurance_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--samples",
        type=float,
        default=1e6,
        help="samples of each case with lambda 0.999 and alpha 1e6 (%(default)g; 0: not tried)",
    )
    parser.add_argument(
        "--others",
        type=float,
        default=0,
        metavar="SAMPLES",
        help="samples of each case with lambda 1, 0.9999, 0.99 and alpha 1e6, 1e3 (default: not tried)",
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), metavar="NAME", help=", ".join(CASES))


def run_endurance(arguments: argparse.Namespace, console: Console) -> int:
    samples, others = (_whole(name, getattr(arguments, name)) for name in ("samples", "others"))
    for name, count in (("samples", samples), ("others", others)):
        if 0 < count < LEAST_SAMPLES or samples == others == 0:
            raise HysgenError(f"{name}: {count}: choose at least {LEAST_SAMPLES}, fewer do not test endurance")
    tests = [test for test in endurance_tests(samples, others) if test.case in arguments.cases]
    results = endure(tests, console.progress)
    console.say(table(HEADINGS, rows(results)))
    failed = [result for result in results if not result.holds]
    console.say(f"\n{len(results) - len(failed)} of {len(results)} hold\n{LEGEND}")
    return console.finish(
        {"allowed_ratio": ALLOWED_RATIO, "trials": [result.to_json() for result in results]}, not failed
    )


def _whole(name: str, value: float) -> int:
    """The whole number `value` (1e8 is one). Raises HysgenError if it is not whole or out of range."""
    if not (0 <= value <= 1e12 and value == int(value)):
        raise HysgenError(f"{name}: {value:g} is not a number of samples; write a whole number, as 1e8")
    return int(value)


TRACK_HELP = """\
Run the complete firmware on the virtual stage through section 4.3 of the paper: tracking error by controller."""


def track_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, metavar="S", help=f"of reference (default {SECONDS:g})"
    )


def run_track(arguments: argparse.Namespace, console: Console) -> int:
    results, noise_nm = track(arguments.seconds, console.progress)
    console.say(tracking_table(results, noise_nm))
    return console.finish({"sensor_noise_nm": noise_nm, "tracking": [vars(result) for result in results]})


def tracking_table(results: list[TrackingResult], noise_nm: float) -> str:
    """Tracking errors by controller, with the sensor's noise and the paper's errors below."""
    rows = [
        [
            f"{result.f_Hz:g} Hz, {result.controller}",
            f"{result.rms_nm:.2f}",
            f"{result.mean_nm:+.2f}",
            f"{result.spread_nm:.2f}",
            f"{result.last_nm:.2f}",
            f"{result.voltage_V[0]:.1f} .. {result.voltage_V[1]:.1f}",
            f"{result.commits}",
        ]
        for result in results
    ]
    header = ["reading minus reference", "rms nm", "mean nm", "spread nm", "last second nm", "voltage V", "commits"]
    paper = ", ".join(f"{nm:g} nm at {f_Hz:g} Hz" for f_Hz, nm in PAPER_NM.items())
    return table(header, rows) + f"\nsensor: {noise_nm:.2f} nm rms; the paper's own stage, by its inverse: {paper}"


GALLERY_HELP = """\
Draw what each cause does to the virtual stage, with it and without it: a page and small pictures (SVG)."""


def gallery_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder of the page")


def run_gallery(arguments: argparse.Namespace, console: Console) -> int:
    files = gallery()
    for name, text in files.items():
        write_whole(Path(arguments.output) / name, text)
    console.say(f"written: {len(files)} files in {arguments.output}")
    return console.finish({"files": sorted(files)})


VERBS = {
    "gallery": Verb(GALLERY_HELP, gallery_arguments, run_gallery, {"output": Output("-o", folder=True)}),
    "experiments": Verb(
        EXPERIMENTS_HELP, experiments_arguments, run_experiments, {"output": Output("-o", folder=True)}
    ),
    "bank": Verb(BANK_HELP, bank_arguments, run_bank),
    "endurance": Verb(ENDURANCE_HELP, endurance_arguments, run_endurance),
    "track": Verb(TRACK_HELP, track_arguments, run_track),
}
