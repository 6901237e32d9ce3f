"""Run the generated learner for hours of samples of poor, broken and endless excitation, and test its recovery.

Every case drives the compiled learner of a model with six rules on the virtual stage. One second of persistent
excitation follows; the free-run error of the learned model is divided by that of a fresh fit to the same second. Eq.
(10) as printed runs in float32 over the same samples. Exit code 1 if a case fails.
"""

from __future__ import annotations

import argparse

from hysgen.checking.endurance import ALLOWED_RATIO, CASES, HEADINGS, endurance_tests, rows
from hysgen.checking.endurance import run as endure
from hysgen.cli.console import Console
from hysgen.display import table
from hysgen.errors import HysgenError

LEAST_SAMPLES = 1000
LEGEND = f"""\
holds:     factors finite, positive and bounded to the end, recovered to at most {ALLOWED_RATIO:g}
recovered: free-run error after one second of persistent excitation, divided by that of a fresh float64 fit to the
           same second with the same lambda; column `lambda 1`: divided by that of a fit without forgetting
Eq. (10):  as printed, in float32, on the same samples without NaN and spikes, which it does not reject"""


def arguments(parser: argparse.ArgumentParser) -> None:
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


def run(arguments: argparse.Namespace, console: Console) -> int:
    samples, others = (_whole(name, getattr(arguments, name)) for name in ("samples", "others"))
    for name, count in (("samples", samples), ("others", others)):
        if 0 < count < LEAST_SAMPLES or samples == others == 0:
            raise HysgenError(f"{name}: {count}: choose at least {LEAST_SAMPLES}, fewer do not test endurance")
    tests = [test for test in endurance_tests(samples, others) if test.case in arguments.cases]
    results = endure(tests, console.progress)
    console.say(table(HEADINGS, rows(results)))
    failed = [result for result in results if not result.holds]
    console.say(f"\n{len(results) - len(failed)} of {len(results)} hold\n{LEGEND}")
    console.write_json({"allowed_ratio": ALLOWED_RATIO, "trials": [result.to_json() for result in results]})
    return 1 if failed else 0


def _whole(name: str, value: float) -> int:
    """A count written as 1e8 or 100000000. Raises HysgenError if it is none."""
    if not (0 <= value <= 1e12 and value == int(value)):
        raise HysgenError(f"{name}: {value:g} is not a number of samples; write a whole number, as 1e8")
    return int(value)
