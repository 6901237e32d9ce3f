"""Let the generated learner run for hours of samples on poor, broken and endless excitation, and see what is left.

Every case drives the compiled learner of a model of six rules on the virtual stage; afterwards one second of good
excitation returns, and the free run of what was learned is held against that of a fresh fit of the same second. Beside
it stands Eq. (10) as printed, in float32. Exit code 1 if a case does not hold.
"""

from __future__ import annotations

import argparse

from hysgen.checking.endurance import ALLOWED_RATIO, CASES, HEADINGS, rows, trials
from hysgen.checking.endurance import run as endure
from hysgen.cli.console import Console
from hysgen.display import table
from hysgen.errors import HysgenError

LEAST_SAMPLES = 1000
LEGEND = f"""\
holds:     factors finite, positive and bounded to the end, recovered to at most {ALLOWED_RATIO:g}
recovered: free-run error, after one second of good excitation has returned, over that of a fresh float64 fit of the
           same second with the same lambda; under `lambda 1`: over that of a fit that weighs the whole second alike
Eq. (10):  as printed, in float32, on the same samples; NaN and spikes left out, for it has no defence against them"""


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
            raise HysgenError(f"{name}: {count}: choose at least {LEAST_SAMPLES}, below that nothing is endured")
    todo = [trial for trial in trials(samples, others) if trial.case in arguments.cases]
    outcomes = endure(todo, console.progress)
    console.say(table(HEADINGS, rows(outcomes)))
    failed = [outcome for outcome in outcomes if not outcome.holds]
    console.say(f"\n{len(outcomes) - len(failed)} of {len(outcomes)} hold\n{LEGEND}")
    console.write_json({"allowed_ratio": ALLOWED_RATIO, "trials": [outcome.to_json() for outcome in outcomes]})
    return 1 if failed else 0


def _whole(name: str, value: float) -> int:
    """A count written as 1e8 or 100000000. Raises HysgenError if it is none."""
    if not (0 <= value <= 1e12 and value == int(value)):
        raise HysgenError(f"{name}: {value:g} is not a number of samples; write a whole number, as 1e8")
    return int(value)
