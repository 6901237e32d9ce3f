"""demo: the whole way on the bundled record."""

import argparse
import time
from pathlib import Path

from hysgen.api.code import cost, generate, verify
from hysgen.api.diagnosing import diagnose, scored_extension
from hysgen.checking import LEVELS, host_compilers, toolchains
from hysgen.cli.console import Console
from hysgen.cli.verbs import Output, Verb, check_file, check_files
from hysgen.cli.verbs.generate import cost_text
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import LADDER
from hysgen.display import table
from hysgen.fitting import FitSettings
from hysgen.machine.files import write_whole
from hysgen.machine.processes import several_processes
from hysgen.model.file import save_model
from hysgen.record import load_record
from hysgen.record.read import IDENTIFICATION_ROWS, bundled_csv
from hysgen.report.pages import diagnosis_page
from hysgen.report.words import verdict

DEMO_HELP = """\
The whole way on the bundled record: diagnosis, C, equality of bits, cost, a page, all in one folder.

The demo does what the other verbs do; each step shows the command that repeats it.
"""
DEMO_FILES = ("paper.json", "stage.json", "report.html")
"""Files of the demo beside record.csv and the generated C."""

DEMO_SAMPLES = 50_000


def demo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", default="hysgen-demo", metavar="DIR", help="folder (default %(default)s)")
    parser.add_argument(
        "--samples",
        type=int,
        default=DEMO_SAMPLES,
        help="samples that verify compares in each build (default %(default)s)",
    )


@several_processes(__name__)
def run_demo(arguments: argparse.Namespace, console: Console) -> int:
    started = time.monotonic()
    toolchains(host_compilers(), LEVELS)  # raises BuildError now, not after the diagnosis
    folder = Path(arguments.output)
    csv, model_file, code, page = (folder / name for name in ("record.csv", "stage.json", "c", "report.html"))
    if not (csv.exists() and csv.read_bytes() == bundled_csv().encode()):
        check_file(csv, "-o", arguments.force)
        write_whole(csv, bundled_csv())
    check_files(folder, DEMO_FILES, "-o", arguments.force)
    record, cut = load_record(csv), IDENTIFICATION_ROWS
    settings = DiagnoseSettings(FitSettings(name="stage"), identify=cut / record.samples)

    command = f"hysgen diagnose {csv} --rows 0:{cut} -o {model_file} --report {page}"
    console.say(f"$ {command}\n{record.one_line()}")
    study = diagnose(record, None, settings, console.progress)
    console.say("\n".join([*verdict(study), "", table(LADDER, study.ladder())]))
    model = scored_extension(study)
    save_model(model, model_file)
    save_model(study.diagnosis.base, folder / "paper.json")

    console.say(f"\n$ hysgen generate {model_file} -o {code}")
    generated = generate(model)
    check_files(code, list(generated.texts), "-o", arguments.force)
    generated.write(code)
    console.say(f"written: {', '.join(sorted(generated.texts))}")

    console.say(f"\n$ hysgen verify {code} --samples {arguments.samples}")
    report = verify(code, arguments.samples, console.progress)
    console.say("\n".join(report.lines()))

    console.say(f"\n$ hysgen cost {code}")
    price = cost(code)
    console.say(cost_text(price))

    write_whole(page, diagnosis_page(study, proof=(report, price), command=command).html())
    seconds = time.monotonic() - started
    console.say(f"\n{seconds:.0f} s; the page with pictures: {page}; models: {model_file}, {folder / 'paper.json'}")
    result = {
        "diagnosis": study.to_json(),
        "verify": report.to_json(),
        "cost": price.to_json(),
        "report": str(page),
        "seconds": round(seconds, 1),
    }
    return console.finish(result, report.equal)


VERBS = {
    "demo": Verb(
        DEMO_HELP, demo_arguments, run_demo, {"output": Output("-o", folder=True)}, ("hysgen demo -o hysgen-demo",)
    )
}
