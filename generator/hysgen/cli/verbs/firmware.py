"""The complete firmware: sizes and cycles of its image, parameter images."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.api.code import Generated, with_kernels
from hysgen.cli.console import Console
from hysgen.cli.options import add_model
from hysgen.cli.outputs import Output, check_files
from hysgen.cli.verbs import Verb
from hysgen.cli.verbs.generate import add_kernels, usable_model
from hysgen.errors import BuildError, ModelError
from hysgen.firmware.binding import build_id, firmware_model, structure_digest, with_learner
from hysgen.firmware.image import Label, encode, read_key
from hysgen.machine.files import write_whole
from hysgen.model.file import load_model
from hysgen.targets import named, targets

FIRMWARE_HELP = """\
Write what the firmware needs of a model (its C and model.h), and say what the image costs on the C6748.

The firmware itself, which calls it, is in firmware/ of the sources; docs/firmware.md says how to put both together."""
IMAGE_HELP = """\
Write a model's numbers as a parameter image, which running firmware takes if it is whole, right and certified."""

SAMPLES = 12_000
"""Of the run on the simulator."""


def firmware_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser, "appendix_a, extended")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for its C and model.h")
    add_kernels(parser)
    parser.add_argument(
        "--samples", type=int, default=SAMPLES, metavar="N", help="on the simulator (default %(default)s)"
    )


def run_firmware(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    if model.learner is None:
        model = with_learner(model)
        console.say(f"{model.name}: no learner settings in the file; one of the rules' consequents is added")
    code = Generated(model, firmware_model(model, aligned=bool(arguments.kernels), forced=arguments.force))
    if arguments.kernels:
        code = with_kernels(code, arguments.kernels)
    for line in code.warnings:
        console.warn(line)
    texts = code.texts
    if arguments.output:
        check_files(Path(arguments.output), list(texts), "-o", arguments.force)
        code.write(Path(arguments.output))
        console.say(f"written: {len(texts)} files in {arguments.output}")
    able = named("firmware")
    result: dict[str, object] = {"model": model.name, "target": None}
    try:
        if not able:
            raise BuildError("no package of a target that the firmware runs on is installed")
        image_cost = targets()[able[0]].firmware
        result |= image_cost(model, texts, arguments.samples, console.say, console.warn) if image_cost else {}
    except BuildError as refusal:
        console.warn(f"sizes and cycles are missing: {refusal}")
    return console.finish(result)


def image_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="model file, or a shipped one")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="the image")
    parser.add_argument(
        "--flashed", metavar="MODEL", help="model that the firmware was built with: the image fits this build only"
    )
    parser.add_argument(
        "--key", required=True, metavar="FILE", help="file with the firmware's key, 32 hexadecimal digits"
    )
    parser.add_argument("--device", default="0", metavar="HEX", help="number of the device (default %(default)s)")
    parser.add_argument(
        "--counter", type=int, default=1, metavar="N", help="larger than that of the last image (default %(default)s)"
    )


def run_image(arguments: argparse.Namespace, console: Console) -> int:
    model = usable_model(arguments)
    words = structure_digest(model)
    if arguments.flashed:
        flashed = load_model(arguments.flashed)
        if structure_digest(flashed) != words:
            raise ModelError(
                f"{arguments.model}: its ranges, partition or shapes are not those of {arguments.flashed}, so the "
                "firmware would refuse the image; refit the flashed model over its range, or build the firmware again"
            )
    data = encode(model, read_key(Path(arguments.key)), _label(arguments))
    write_whole(Path(arguments.output), data)
    fits = "".join(f"{word:08x}" for word in words)
    console.say(f"written: {arguments.output} ({len(data)} bytes; fits firmware with structure {fits})")
    return console.finish({"model": model.name, "file": arguments.output, "bytes": len(data), "structure": fits})


def _label(arguments: argparse.Namespace) -> Label:
    """Raises ModelError for a device or a counter that does not fit its words."""
    try:
        device = int(arguments.device, 16)
    except ValueError:
        device = -1
    if not (0 <= device < 1 << 64 and 0 < arguments.counter < 1 << 32):
        raise ModelError("--device is a hexadecimal number of up to 16 digits, --counter one of 1 to 4294967295")
    build = build_id(load_model(arguments.flashed)) if arguments.flashed else 0
    return Label(device, build, arguments.counter)


VERBS = {
    "firmware": Verb(FIRMWARE_HELP, firmware_arguments, run_firmware, {"output": Output("-o", folder=True)}),
    "image": Verb(IMAGE_HELP, image_arguments, run_image, {"output": Output("-o")}),
}
