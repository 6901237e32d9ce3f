"""Write a model's numbers as a parameter image, which running firmware takes if it is whole, right and certified."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.errors import ModelError
from hysgen.firmware.binding import structure_digest
from hysgen.firmware.image import encode
from hysgen.machine.files import write_whole
from hysgen.model.file import load_model


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="model file, or a shipped one")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="the image")
    parser.add_argument(
        "--flashed", metavar="MODEL", help="model that the firmware was built with: does the image fit?"
    )


def run(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    words = structure_digest(model)
    if arguments.flashed:
        flashed = load_model(arguments.flashed)
        if structure_digest(flashed) != words:
            raise ModelError(
                f"{arguments.model}: its ranges, partition or shapes are not those of {arguments.flashed}, so the "
                "firmware would refuse the image; refit the flashed model over its range, or build the firmware again"
            )
    data = encode(model)
    write_whole(Path(arguments.output), data)
    fits = "".join(f"{word:08x}" for word in words)
    console.say(f"written: {arguments.output} ({len(data)} bytes; fits firmware with structure {fits})")
    console.write_json({"model": model.name, "file": arguments.output, "bytes": len(data), "structure": fits})
    return 0
