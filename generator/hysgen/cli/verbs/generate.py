"""generate: the C of a model; cost: its operations, cycles and bytes.

export: folders that bring a model into Simulink, FMI, XCP, CMake, a shared library, a Cortex-M.
"""

import argparse
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from hysgen.api.code import cost, generate, with_kernels
from hysgen.checking.cost import Cost
from hysgen.cli.console import Console
from hysgen.cli.options import add_folder, add_learner_options, add_model, with_learner
from hysgen.cli.verbs import Output, Verb, check_files
from hysgen.codegen import Derived, Options
from hysgen.codegen.manifest import MANIFEST, read_folder, stale
from hysgen.codegen.operations import C674X, CLOCK_HZ
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.export import compare, export_of, exports, write_export
from hysgen.model.file import load_model
from hysgen.model.model import Model
from hysgen.targets import Target, TargetCost, named, target, targets

GENERATE_HELP = """\
Generate the C of a model: header, source, parameters, self-test, manifest; with --learn, the learner too.

With --check nothing is written: exit code 0 says that every file in the folder is what would be generated now, 1 that
some are stale, which are then listed.
"""
COST_HELP = """\
State what generated C costs: operations by kind, bytes, cycles against the sample period, host time.
"""


def generate_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder for the files")
    add_code_options(parser)
    add_kernels(parser)
    parser.add_argument(
        "--assembler",
        choices=list(dict.fromkeys(syntax for item in targets().values() for syntax in assemblers(item))),
        help="with --kernels; ti: also write NAME_c674x.asm, the same instructions in the syntax of TI's assembler",
    )
    parser.add_argument("--check", action="store_true", help="only say whether the files in DIR are up to date")
    add_learner_options(parser)


def assemblers(item: Target) -> tuple[str, ...]:
    """Syntaxes of the file of a target's kernels, () without kernels."""
    return item.kernels.assemblers if item.kernels else ()


def add_kernels(parser: argparse.ArgumentParser) -> None:
    """The processor whose scheduled kernels take the place of functions."""
    parser.add_argument(
        "--kernels",
        type=lambda name: target(name, "kernels"),
        metavar="{" + ",".join(named("kernels")) + "}",
        help="also write NAME_c674x.s: the functions scheduled for this processor, equal to the C in every bit",
    )


def add_code_options(parser: argparse.ArgumentParser) -> None:
    """Ranges, the inverse, and what the processor gives to one sample."""
    parser.add_argument(
        "--displacement-range",
        nargs=2,
        type=float,
        metavar=("LOW", "HIGH"),
        help="use the model, and certify it, over this part of its displacements in um only",
    )
    parser.add_argument(
        "--input-range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="and over this part of its inputs in V"
    )
    parser.add_argument("--no-inverse", action="store_true", help="leave the inverse out")
    group = parser.add_argument_group("the processor (default: a C6748 at 375 MHz, the whole sample period)")
    group.add_argument("--clock", type=float, metavar="HZ", help="clock of the processor")
    group.add_argument("--budget", type=int, metavar="CYCLES", help="cycles that one sample may take")
    group.add_argument(
        "--cycles",
        default="",
        metavar="FUNCTION=N,...",
        help="cycles of a call that you measured; without them the estimate for the C674x stands for any processor",
    )


def code_options(arguments: argparse.Namespace, model: Model) -> Options:
    """The options of a model's generated code. Raises HysgenError for a text of --cycles that is not FUNCTION=N,..."""
    cycles: dict[str, int] = {}
    for part in filter(None, arguments.cycles.split(",")):
        function, equals, number = part.partition("=")
        if not equals or not number.strip().isdigit():
            raise HysgenError(f"--cycles: '{part}' is not FUNCTION=N; write predict=310,inverse=900")
        cycles[function.strip()] = int(number)
    clock = CLOCK_HZ if arguments.clock is None else arguments.clock
    if not clock > 0.0 or (arguments.budget is not None and arguments.budget < 1):
        raise HysgenError("--clock and --budget are positive; give the clock in Hz and the budget in cycles")
    inverse = not (arguments.no_inverse or Derived(model).predict_only)
    return Options(inverse, clock, cycles, arguments.budget, forced=arguments.force)


def run_generate(arguments: argparse.Namespace, console: Console) -> int:
    model = restricted(with_learner(load_model(arguments.model), arguments), arguments)
    if arguments.assembler and not arguments.kernels:
        known = " or ".join(named("kernels"))
        raise HysgenError(
            f"--assembler {arguments.assembler} is the syntax of the kernels' file; add --kernels {known}"
        )
    options = dataclasses.replace(code_options(arguments, model), aligned=bool(arguments.kernels))
    code = generate(model, options)
    if arguments.kernels:
        code = with_kernels(code, arguments.kernels, arguments.assembler)
    for line in code.warnings:
        console.warn(line)
    folder = Path(arguments.output)
    if arguments.check:
        return check(code.texts, folder, console)
    check_files(folder, list(code.texts), "-o", arguments.force)
    code.write(folder)
    sizes = {name: len(text.encode()) for name, text in code.texts.items()}
    for name, size in sizes.items():
        console.say(f"written: {folder / name} ({size} bytes)")
    return console.finish({"model": model.name, "files": sizes})


def usable_model(arguments: argparse.Namespace) -> Model:
    """The model of the call. Raises ModelError without --force if it explains next to nothing of its record."""
    model = load_model(arguments.model)
    if not arguments.force:
        Derived(model).require_use(inverse=False)
    return model


def restricted(model: Model, arguments: argparse.Namespace) -> Model:
    """The model restricted to the ranges in the options; unchanged without options."""
    displacement, voltage = arguments.displacement_range, arguments.input_range
    if displacement is None and voltage is None:
        return model
    return model.within(tuple(displacement) if displacement else None, tuple(voltage) if voltage else None)


def check(texts: Mapping[str, str], folder: Path, console: Console) -> int:
    """Compare the folder with the generated texts and list stale files. Returns 0 if there are none, else 1."""
    differences = stale(texts, folder)
    for item in differences:
        console.say(f"stale: {folder / item.name}: {str(item).partition(': ')[2]}")
    console.say(
        f"{folder}: {len(differences)} of {len(texts)} files are stale; generate them again"
        if differences
        else f"{folder}: all {len(texts)} files are up to date"
    )
    answer = {"up_to_date": not differences, "stale": [vars(item) for item in differences]}
    return console.finish(answer, not differences)


def cost_arguments(parser: argparse.ArgumentParser) -> None:
    add_folder(parser)
    parser.add_argument(
        "--target",
        type=lambda name: target(name, "weights"),
        metavar="{" + ",".join(named("weights")) + "}",
        help="cycles of this processor: counted on the instruction set (c674x) or by a model of it",
    )


def run_cost(arguments: argparse.Namespace, console: Console) -> int:
    item: Target | None = arguments.target
    folder = Path(arguments.folder)
    generated = read_folder(folder)
    measured = item.cost(generated.model, generated.texts) if item and item.cost else None
    cycles = (
        {function: row["cycles"] for function, row in measured.figures.items() if "cycles" in row} if measured else {}
    )
    price = cost(folder, cycles, timed=True, weights=item.weights if item and item.weights else C674X)
    console.say(cost_text(price))
    answer = price.to_json()
    if measured:
        console.say("\n".join([footprint_text(price.processor, measured), *measured.notes]))
        answer |= {"target": measured.figures, **measured.further}
    return console.finish(answer)


def footprint_text(processor: str, measured: TargetCost) -> str:
    """Cycles, code and stack by function on the target, and the bytes of data."""
    columns = ("cycles", "code_bytes", "stack_bytes")
    rows = [
        [name, *(f"{figures[column]}" if column in figures else "-" for column in columns)]
        for name, figures in measured.figures.items()
        if name != "data"
    ]
    data = measured.figures["data"]
    below = f"data: {data['struct_bytes']} bytes of structs, {data['constant_bytes']} of constants"
    return "\n".join(["", table([f"on the {processor}", "cycles", "code bytes", "stack bytes"], rows), below])


def cost_text(price: Cost) -> str:
    """A table with one row per function, and notes on its columns."""
    return "\n".join([table(price.header(), price.rows()), *price.notes()])


EXPORT_HELP = """\
Export a model into another tool: a folder with README, build and example around the generated C.

With --check N the target is run over N samples of every mode and compared, bit for bit, with the generated C;
exit code 1 says that some differ.
"""


def export_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    parser.add_argument("--to", required=True, choices=tuple(exports()), help="the target")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder for the files")
    parser.add_argument("--check", type=int, metavar="N", help="run N samples of every mode and compare the bits")
    add_code_options(parser)
    for export in exports().values():
        group = parser.add_argument_group(export.options_title) if export.options else parser
        for option in export.options:
            group.add_argument(f"--{option.name}", default="", metavar=option.metavar, help=option.help)
    add_learner_options(parser)


def run_export(arguments: argparse.Namespace, console: Console) -> int:
    model = restricted(with_learner(load_model(arguments.model), arguments), arguments)
    chosen = export_of(arguments.to)
    for export in exports().values():
        given = [f"--{option.name}" for option in export.options if getattr(arguments, option.name)]
        if given and export is not chosen:
            raise HysgenError(f"{', '.join(given)}: for --to {export.name} alone; leave it out")
    if arguments.check is not None and (arguments.check < 1 or not chosen.ways):
        runs = ", ".join(export.name for export in exports().values() if export.ways)
        raise HysgenError(f"--check N compares at least 1 sample of a target that runs: {runs}")
    options = code_options(arguments, model)
    folder = Path(arguments.output)
    others = folder.is_dir() and any(folder.iterdir()) and not (folder / "model" / MANIFEST).exists()
    if others and not arguments.force:
        raise HysgenError(f"-o {folder}: holds files of others; choose another folder, or add --force")
    values = {option.name: getattr(arguments, option.name) for option in chosen.options}
    written = write_export(model, arguments.to, folder, options, values)
    own = [path for path in written if "model" not in path.relative_to(folder).parts]
    for path in own:
        console.say(f"written: {path} ({path.stat().st_size} bytes)")
    console.say(f"written: {folder / 'model'} ({len(written) - len(own)} files of the generated C)")
    answer = {"model": model.name, "target": arguments.to, "files": [str(path) for path in written]}
    if arguments.check is None:
        return console.finish(answer)
    compared = compare(model, arguments.to, folder, arguments.check, options, progress=console.progress)
    for line in compared:
        console.say(str(line))
    checked = [vars(line) for line in compared]
    return console.finish({**answer, "checked": checked}, not any(line.differ for line in compared))


VERBS = {
    "generate": Verb(
        GENERATE_HELP,
        generate_arguments,
        run_generate,
        {"output": Output("-o", folder=True)},
        (
            "hysgen generate stage.json -o firmware/stage",
            "hysgen generate stage.json -o c --learn rules",
            "hysgen generate stage.json -o c --kernels c674x",
        ),
    ),
    "cost": Verb(COST_HELP, cost_arguments, run_cost, examples=("hysgen cost c", "hysgen cost c --target c674x")),
    "export": Verb(EXPORT_HELP, export_arguments, run_export, {"output": Output("-o", folder=True)}),
}
