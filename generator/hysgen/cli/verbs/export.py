"""export: folders that bring a model into Simulink, FMI, XCP, CMake, a shared library, a Cortex-M."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.options import add_learner_options, add_model, with_learner
from hysgen.cli.outputs import Output
from hysgen.cli.verbs import Verb
from hysgen.cli.verbs.generate import add_code_options, code_options, restricted
from hysgen.codegen.manifest import MANIFEST
from hysgen.errors import HysgenError
from hysgen.export import export_of, exports, write_export
from hysgen.export.check import compare
from hysgen.model.file import load_model

HELP = """\
Export a model into another tool: a folder with README, build and example around the generated C.

With --check N the target is run over N samples of every mode and compared, bit for bit, with the generated C;
exit code 1 says that some differ.
"""


def arguments(parser: argparse.ArgumentParser) -> None:
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


def run(arguments: argparse.Namespace, console: Console) -> int:
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


VERBS = {"export": Verb(HELP, arguments, run, {"output": Output("-o", folder=True)})}
