"""Commands to running firmware over its serial line."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.outputs import Output
from hysgen.cli.verbs import Verb
from hysgen.display import table
from hysgen.errors import ModelError
from hysgen.firmware.host import FirmwareStatus, Request, State
from hysgen.firmware.image import read_key
from hysgen.firmware.link import BAUD, Client, open_line, read_table, record_text
from hysgen.firmware.wire import LinkStatus
from hysgen.machine.files import write_whole
from hysgen.model.file import load_model

LINK_HELP = """\
Talk to running firmware over its serial line: state, start, stop, clear, reference, parameter images, records.

    hysgen link /dev/ttyUSB0 status
    hysgen link /dev/ttyUSB0 start
    hysgen link /dev/ttyUSB0 reference 2.1        (um; without a number: the board's own reference again)
    hysgen link /dev/ttyUSB0 image FILE           (written by hysgen image)
    hysgen link /dev/ttyUSB0 install MODEL --key FILE
    hysgen link /dev/ttyUSB0 record TABLE -o record.csv   (plays its voltages: time_s,voltage_V)

Needs pyserial (pip install 'hysgen[link]')."""

ACTIONS = ("status", "identify", "start", "stop", "clear", "reference", "image", "install", "record")


def link_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("port", metavar="PORT", help="serial port, or a URL of pyserial such as socket://host:port")
    parser.add_argument("action", nargs="?", default="status", choices=ACTIONS, help="default: status")
    parser.add_argument(
        "value", nargs="?", metavar="VALUE", help="of reference (um), image (file), install (model), record (table)"
    )
    parser.add_argument("--baud", type=int, default=BAUD, help="bits per second (default %(default)s)")
    parser.add_argument("-o", "--output", metavar="FILE", help="of record: what the sensor read")
    parser.add_argument("--key", metavar="FILE", help="file with the key of install, 32 hexadecimal digits")


def run_link(arguments: argparse.Namespace, console: Console) -> int:
    needs = arguments.action in ("image", "install", "record")
    if (arguments.value is None) == needs and (needs or arguments.action != "reference"):
        raise ModelError(
            f"{arguments.action}: " + ("name the file, model or table to send" if needs else "takes no value")
        )
    for given, flag, action in ((arguments.output, "-o", "record"), (arguments.key, "--key", "install")):
        if (given is None) == (arguments.action == action):
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
    elif action == "record":
        recorded = client.record(*read_table(Path(value)), lambda share: console.progress(share, "record"))
        write_whole(Path(arguments.output), record_text(*recorded))


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


VERBS = {"link": Verb(LINK_HELP, link_arguments, run_link, {"output": Output("-o", (".csv",))})}
