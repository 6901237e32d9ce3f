"""Entry of the command line: runs the verb and turns each error into one line and an exit code.

Exit codes: 0 done; 1 done with a negative answer (bits differ, a file is stale, a model misses its target);
2 not done: bad input, a missing tool, no memory, no room on the disk; 3 a fault of hysgen itself; 130 interrupted.
"""

import argparse
import contextlib
import itertools
import os
import re
import shutil
import sys
import tempfile
import textwrap
import tomllib
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn, TextIO

from hysgen.cli.console import Console, discard_stdout, folded
from hysgen.cli.verbs import GROUPS, NAMES, Program, check_outputs, verb
from hysgen.display import WRITTEN_IN, written_in
from hysgen.errors import HysgenError, nearest
from hysgen.machine.files import version
from hysgen.machine.processes import LIBRARIES, require_room

_DESCRIPTION = (
    "From measured voltage/displacement records of a piezo stage to verified float32 C: "
    "fit a fuzzy hysteresis model, see what its simulation gets wrong, and generate prediction, learning and inverse."
)
_FIRST_STEPS = {
    "hysgen demo": "the whole way on the bundled record",
    "hysgen inspect record.csv": "what the file holds",
    "hysgen diagnose record.csv -o stage.json": "causes of the error, an extended model",
    "hysgen generate stage.json -o c": "its C",
    "hysgen verify c": "equal to the reference in every bit",
}
LEAST_BESIDE = 24
"""Columns that the meaning of a command needs beside it; in fewer it stands below."""

_BELOW = """\
`hysgen VERB --help` has options and examples; `hysgen completion bash` completes them.
hysgen.toml in the working folder holds options for every call ([record] columns = "...").
Exit codes: 0 done, 1 done with a negative answer, 2 not done, 3 a fault of hysgen itself.
HYSGEN_CACHE names the folder of compiled kernels (default: hysgen in the user's cache folder).
HYSGEN_PROCESSES is the number of processes of a diagnosis (default: one for each core, at most 4)."""

HYSGEN = Program("hysgen", _DESCRIPTION, GROUPS, lambda name: verb(name), _FIRST_STEPS, _BELOW)


class _Parser(argparse.ArgumentParser):
    """argparse with one-line errors, as in the rest of the program."""

    def error(self, message: str) -> NoReturn:
        if re.search(r"unrecognized arguments:.*--(time|voltage|displacement)\b", message):
            message += "; columns are named by --columns time=NAME,voltage=NAME,displacement=NAME"
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser(names: Sequence[str] = NAMES, program: Program = HYSGEN) -> argparse.ArgumentParser:
    """The parser of the command line with the verbs `names`, whose modules are imported."""
    top = _Parser(prog=program.name, description=program.description)
    top.add_argument("-V", "--version", action="version", version=f"hysgen {version()}")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True, parser_class=_Parser)
    for name in names:
        chosen = program.verb(name)
        sub = verbs.add_parser(
            name,
            description=_paragraphs(chosen.help),
            formatter_class=argparse.RawDescriptionHelpFormatter,
            epilog=_examples(chosen.examples) if chosen.examples else None,
        )
        chosen.arguments(sub)
        sub.add_argument("--json", metavar="FILE", help="write the result as JSON to FILE, or to stdout with -")
        sub.add_argument(
            "--force", action="store_true", help="replace files of others, use a model that explains nothing"
        )
        sub.add_argument("-q", "--quiet", action="store_true", help="no progress and no warnings")
        sub.add_argument("-v", "--verbose", action="store_true", help="every step on a line of its own, with its time")
        sub.set_defaults(run=chosen.run, outputs=chosen.outputs)
        if len(names) == 1:
            sub.set_defaults(**project_options(name, sub, tuple(dict.fromkeys((*program.names, *NAMES)))))
    return top


def _paragraphs(text: str) -> str:
    """The text with each paragraph folded to the terminal; indented lines stay."""
    columns = shutil.get_terminal_size().columns
    parts = text.strip("\n").split("\n\n")
    return "\n\n".join(part if part.startswith(" ") else textwrap.fill(part, columns) for part in parts)


def _examples(lines: Sequence[str]) -> str:
    """The examples; where one is too long for the terminal, what it does stands in a line of its own."""
    columns = shutil.get_terminal_size().columns
    made = []
    for line in lines:
        command, _, comment = line.partition("   ")
        fits = len(line) + 2 <= columns or not comment
        made += [f"  {line}"] if fits else [f"  {command}", f"      {comment.strip()}"]
    return "\n".join(["examples:", *made])


def overview(program: Program = HYSGEN) -> str:
    """The text of `hysgen --help`: the verbs in groups, without importing any of them."""
    columns = shutil.get_terminal_size().columns
    lines = [f"usage: {program.name} VERB ... [--help]", "", *textwrap.wrap(program.description, columns), ""]
    groups = {title: {name: summary for name, (_, summary) in verbs.items()} for title, verbs in program.groups.items()}
    for title, entries in {**groups, **({"first steps": program.first} if program.first else {})}.items():
        width = max(map(len, entries if title == "first steps" else program.names)) + 2
        lines.append(f"{title}:")
        # Beside long commands there may be no room.
        beside = columns - width - 2 >= LEAST_BESIDE
        for name, summary in entries.items():
            parts = textwrap.wrap(summary, columns - width - 2 if beside else columns - 6)
            first = f"  {name:<{width}}{parts.pop(0)}" if beside else f"  {name}"
            lines += [first, *(" " * (width + 2 if beside else 6) + part for part in parts)]
        lines.append("")
    return "\n".join([*lines, folded(program.below, columns)])


def main(argv: Sequence[str] | None = None, program: Program = HYSGEN) -> int:
    """Run one verb. Returns the exit code. An error of the user or of the machine is one line without traceback."""
    sys.stdout, sys.stderr = sys.stdout or _nowhere(), sys.stderr or _nowhere()
    words = list(sys.argv[1:] if argv is None else argv)
    name = next((word for word in words if not word.startswith("-")), "")
    command = f"{program.name} {name}"
    try:
        return _run(words, program)
    except HysgenError as fault:
        return _fails(command, str(fault))
    except MemoryError as fault:
        return _fails(command, f"not enough memory ({fault}); use fewer rows with --rows, or a machine with more")
    except ImportError as fault:
        return _fails(command, f"a library cannot be loaded ({fault}): not enough memory, or a damaged installation")
    except KeyboardInterrupt:
        print(f"\n{command}: interrupted; files already written are whole", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader closed the pipe. This is no error, and Python must not report one when it closes stdout.
        discard_stdout()
        return 0
    except OSError as fault:
        discard_stdout()
        file = f"{fault.filename}: " if fault.filename else ""
        return _fails(command, f"{file}{fault.strerror or fault}; the result is not complete")
    except Exception as fault:
        if "-v" in words or "--verbose" in words:
            raise
        place = traceback.extract_tb(fault.__traceback__)[-1]
        what = f"{type(fault).__name__} in {Path(place.filename).name}:{place.lineno}: {fault}"
        _fails(command, f"a fault of hysgen itself ({what}); please report it, with what --verbose prints")
        return 3


def _verb_first(words: list[str]) -> list[str]:
    """The words with -q and -v behind the verb, where every verb has them."""
    count = len(list(itertools.takewhile(lambda word: word in ("-q", "--quiet", "-v", "--verbose"), words)))
    return [*words[count : count + 1], *words[:count], *words[count + 1 :]]


def _run(words: list[str], program: Program) -> int:
    words = _verb_first(words)
    if words in (["--help"], ["-h"], ["help"], []):
        print(overview(program), flush=True)
        return 0 if words else 2
    if words[:1] == ["help"]:
        words = [*words[1:2], "--help"]
    if words in (["--version"], ["-V"]):
        print(f"hysgen {version()}", flush=True)
        return 0
    if words[0] == "completion" and program is HYSGEN:
        if len(words) != 2 or words[1] not in SHELLS:
            raise HysgenError(f"completion: name a shell out of {', '.join(SHELLS)}")
        print(script(words[1], options_of(parser())), end="", flush=True)
        return 0
    known = program.names
    names = [words[0]] if words[0] in known else known
    if names is known and not words[0].startswith("-"):
        raise HysgenError(f"{words[0]}: is no verb{nearest(words[0], known)}; {program.name} --help lists them")
    require_room(LIBRARIES)
    _place_matplotlib()
    arguments = parser(names, program).parse_args(_negative_rows_joined(words))
    console = Console(json_to=arguments.json, verb=arguments.verb, quiet=arguments.quiet, verbose=arguments.verbose)
    check_outputs(arguments, arguments.outputs)
    from hysgen.cli.options import quantities_of  # imports NumPy, which --version does without

    try:
        with console.warnings_of_records(), written_in(quantities_of(arguments)):
            try:
                code = int(arguments.run(arguments, console))
            except HysgenError as fault:
                raise HysgenError(WRITTEN_IN.get().text(str(fault))) from fault
    finally:
        console.close()
    sys.stdout.flush()
    return code


def _place_matplotlib() -> None:
    """Give matplotlib a folder for its settings where the home cannot be written; else it says so on stderr."""
    if "MPLCONFIGDIR" in os.environ:
        return
    home = Path(os.environ.get("HOME", "/"))
    try:
        with tempfile.TemporaryFile(dir=next(folder for folder in (home, *home.parents) if folder.exists())):
            pass
    except OSError:
        from hysgen.machine.native import cache_folder  # imports NumPy, which --version does without

        with contextlib.suppress(HysgenError):
            os.environ["MPLCONFIGDIR"] = str(cache_folder() / "matplotlib")


def _negative_rows_joined(words: Sequence[str]) -> list[str]:
    """The words with `--rows -2000:` as `--rows=-2000:`: argparse takes a value with a minus sign for an option."""
    joined: list[str] = []
    for word in words:
        if joined and joined[-1] == "--rows" and re.match(r"-[\d.]", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _fails(command: str, text: str) -> int:
    with contextlib.suppress(OSError):
        print(f"{command}: {' '.join(text.split())}", file=sys.stderr, flush=True)
    return 2


def _nowhere() -> TextIO:
    """What takes the place of a standard stream that a scheduler has closed."""
    return os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8")


SHELLS = ("bash", "zsh", "fish")


def script(shell: str, options: Mapping[str, Sequence[str]]) -> str:
    """The text for a shell's start-up file. options: the options of each verb."""
    if shell == "fish":
        verbs = " ".join(options)
        lines = [f"complete -c hysgen -n __fish_use_subcommand -f -a '{verbs}'"]
        lines += [
            f"complete -c hysgen -n '__fish_seen_subcommand_from {verb}' -l {option.removeprefix('--')}"
            for verb, names in options.items()
            for option in names
            if option.startswith("--")
        ]
        return "\n".join(lines) + "\n"
    cases = "\n".join(f"        {verb}) words='{' '.join(names)}' ;;" for verb, names in options.items())
    head = "autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    return f"""{head}_hysgen() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" words
    case "${{COMP_WORDS[1]}}" in
{cases}
    esac
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W '{" ".join(options)}' -- "$word"))
    elif [ "${{word#-}}" != "$word" ]; then
        COMPREPLY=($(compgen -W "$words" -- "$word"))
    else
        COMPREPLY=($(compgen -f -- "$word"))
    fi
}}
complete -o filenames -F _hysgen hysgen
"""


def options_of(parser: argparse.ArgumentParser) -> dict[str, list[str]]:
    """The options of each verb of the whole parser."""
    verbs = next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    return {
        name: [option for action in sub._actions for option in action.option_strings]
        for name, sub in verbs.choices.items()
    }


NAME = "hysgen.toml"
RECORD = "record"
"""Table whose options are those of every verb that reads a record."""


def project_options(verb: str, parser: argparse.ArgumentParser, known: tuple[str, ...]) -> dict[str, Any]:
    """Defaults for the parser of a verb, by destination. known: names of all verbs.

    Raises HysgenError for a file that is no TOML, for a table that is no verb, and for a key that is no option.
    """
    path = Path(NAME)
    if not path.is_file():
        return {}
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as fault:
        raise HysgenError(f"{NAME}: cannot be read ({fault}); correct it, or remove it") from fault
    for table, options in tables.items():
        if not isinstance(options, dict):
            raise HysgenError(f"{NAME}: {table} stands outside a table; write it below [{RECORD}] or a verb")
        if table != RECORD and table not in known:
            raise HysgenError(f"{NAME}: [{table}] is no verb; write [{RECORD}] or one of {', '.join(known)}")
    actions = {
        option[2:]: action for action in parser._actions for option in action.option_strings if option.startswith("--")
    }
    given: dict[str, Any] = {}
    for table in (RECORD, verb):
        for key, value in tables.get(table, {}).items():
            action = actions.get(key.replace("_", "-"))
            if action is not None:
                given[action.dest] = _converted(action, key, value)
            elif table == verb or "columns" in actions:
                raise HysgenError(
                    f"{NAME}: [{table}] {key}: hysgen {verb} has no option --{key}{nearest(key, actions)}; "
                    f"see hysgen {verb} --help"
                )
    return given


def _converted(action: argparse.Action, key: str, value: Any) -> Any:
    """A value as the option would have it. Raises HysgenError if it does not suit."""
    try:
        if action.type is not None and not isinstance(value, (bool, list)):
            value = action.type(str(value))  # type: ignore[operator]
    except (TypeError, ValueError) as fault:
        raise HysgenError(f"{NAME}: {key} = {value!r} does not suit --{key}; correct it") from fault
    if action.choices is not None:
        for item in value if isinstance(value, list) else [value]:
            if item not in action.choices:
                raise HysgenError(f"{NAME}: {key} = {item!r}: choose from {', '.join(map(str, action.choices))}")
    return value
