"""Completion of verbs, options and files for bash, zsh and fish, made from the parsers themselves."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence

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
