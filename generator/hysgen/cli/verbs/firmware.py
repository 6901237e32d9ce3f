"""The complete firmware: sizes and cycles of its image, parameter images.

Commands to running firmware over its serial line.
"""

import argparse
from pathlib import Path

from hysgen.api.code import Generated, with_kernels
from hysgen.cli.console import Console
from hysgen.cli.options import add_model
from hysgen.cli.verbs import Output, Verb, check_files
from hysgen.cli.verbs.generate import add_kernels, usable_model
from hysgen.display import table
from hysgen.errors import BuildError, ModelError
from hysgen.firmware import Label, build_id, encode, firmware_model, read_key, structure_digest, with_learner
from hysgen.firmware.link import BAUD, Client, kept_text, open_line, read_kept, read_table, record_text
from hysgen.firmware.wire import FirmwareStatus, LinkStatus, Request, State
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


LINK_HELP = """\
Talk to running firmware over its serial line: state, start, stop, clear, reference, parameter images, records.

    hysgen link /dev/ttyUSB0 status
    hysgen link /dev/ttyUSB0 start
    hysgen link /dev/ttyUSB0 reference 2.1        (um; without a number: the board's own reference again)
    hysgen link /dev/ttyUSB0 image FILE           (written by hysgen image)
    hysgen link /dev/ttyUSB0 install MODEL --key FILE
    hysgen link /dev/ttyUSB0 read -o FILE         (parameters, learnt ones too, and settings, as JSON)
    hysgen link /dev/ttyUSB0 write FILE --key FILE
    hysgen link /dev/ttyUSB0 record TABLE -o record.csv   (plays its voltages: time_s,voltage_V)
    hysgen link /dev/ttyUSB0 trace -o trace.csv           (the 1024 samples around the first fault)

Needs pyserial (pip install 'hysgen[link]')."""

ACTIONS = (
    *("status", "identify", "start", "stop", "clear", "reference"),
    *("image", "install", "read", "write", "record", "trace"),
)


def link_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("port", metavar="PORT", help="serial port, or a URL of pyserial such as socket://host:port")
    parser.add_argument("action", nargs="?", default="status", choices=ACTIONS, help="default: status")
    parser.add_argument(
        "value",
        nargs="?",
        metavar="VALUE",
        help="of reference (um), image, write, record (file), install (model)",
    )
    parser.add_argument("--baud", type=int, default=BAUD, help="bits per second (default %(default)s)")
    parser.add_argument("-o", "--output", metavar="FILE", help="of record, trace and read")
    parser.add_argument("--key", metavar="FILE", help="file with the key of install and write, 32 hexadecimal digits")


def run_link(arguments: argparse.Namespace, console: Console) -> int:
    needs = arguments.action in ("image", "install", "write", "record")
    if (arguments.value is None) == needs and (needs or arguments.action != "reference"):
        raise ModelError(
            f"{arguments.action}: " + ("name the file, model or table to send" if needs else "takes no value")
        )
    written, signed = arguments.action in ("record", "trace", "read"), arguments.action in ("install", "write")
    for given, flag, asked in ((arguments.output, "-o", written), (arguments.key, "--key", signed)):
        if (given is None) == asked:
            raise ModelError(f"{arguments.action}: " + (f"takes no {flag}" if given else f"name the file: {flag} FILE"))
    with Client(open_line(arguments.port, arguments.baud)) as client:
        if arguments.action == "identify":
            identity = client.identity()
            console.say(table(["firmware", ""], [[name, str(value)] for name, value in vars(identity).items()]))
            return console.finish(vars(identity))
        _act(client, arguments, console)
        status = client.status()
    console.say(status_table(status))
    return console.finish(vars(status))


def _act(client: Client, arguments: argparse.Namespace, console: Console) -> None:
    action, value = arguments.action, arguments.value
    if action in ("start", "stop", "clear"):
        client.request(Request[action.upper()])
    elif action == "reference":
        try:
            client.reference(None if value is None else float(value))
        except ValueError:
            raise ModelError(f"{value}: is no number; the reference is a displacement in um") from None
    elif action == "image":
        client.install(_image(Path(value)), lambda share: console.progress(share, "image"))
    elif action == "install":
        client.install_model(
            load_model(value), read_key(Path(arguments.key)), lambda share: console.progress(share, "image")
        )
    elif action == "read":
        write_whole(Path(arguments.output), kept_text(client.stored()))
    elif action == "write":
        client.keep(
            read_kept(Path(value)), read_key(Path(arguments.key)), lambda share: console.progress(share, "image")
        )
        console.say("its parameters drive from the next start on, its settings from the next boot on")
    elif action == "record":
        recorded = client.record(*read_table(Path(value)), lambda share: console.progress(share, "record"))
        write_whole(Path(arguments.output), record_text(*recorded))
    elif action == "trace":
        write_whole(Path(arguments.output), client.trace(lambda share: console.progress(share, "trace")))


def _image(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as fault:
        raise ModelError(f"{file}: cannot be read ({fault.strerror})") from fault


def status_table(status: LinkStatus) -> str:
    """The status as rows of name and value."""
    bits = {name: FirmwareStatus(getattr(status, name)).name or "0" for name in ("status", "first_fault")}
    named = vars(status) | {"state": State(status.state).name, **bits}
    rows = [[name, f"{value:.6g}" if isinstance(value, float) else str(value)] for name, value in named.items()]
    return table(["firmware", ""], rows)


VERBS = {
    "firmware": Verb(FIRMWARE_HELP, firmware_arguments, run_firmware, {"output": Output("-o", folder=True)}),
    "image": Verb(IMAGE_HELP, image_arguments, run_image, {"output": Output("-o")}),
    "link": Verb(LINK_HELP, link_arguments, run_link, {"output": Output("-o", (".csv", ".json"))}),
}
