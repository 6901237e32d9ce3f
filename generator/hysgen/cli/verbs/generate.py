"""Generate the C of a model: header, source, parameters, self-test, manifest."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.emit import Options, generate, write
from hysgen.model_file import load_model


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="model file, or a shipped one: appendix_a, appendix_b")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder for the files")
    parser.add_argument("--no-inverse", action="store_true", help="leave the inverse out")


def run(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    texts = generate(model, Options(inverse=not arguments.no_inverse))
    folder = Path(arguments.output)
    write(texts, folder)
    for name, text in texts.items():
        console.say(f"written: {folder / name} ({len(text.encode())} bytes)")
    console.write_json({"model": model.name, "files": {name: len(text.encode()) for name, text in texts.items()}})
    return 0
