"""What the documents say can be done, can be done: their commands are the program's, their links lead somewhere."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import hysgen
from hysgen import api
from hysgen.cli.main import parser

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMAND = re.compile(r"^(?:    |\$ )?(hysgen [a-z].*)$", re.MULTILINE)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)")
by_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def commands(text: str) -> list[str]:
    """Commands shown in blocks, without the remark behind them; continued lines joined."""
    blocks = re.findall(r"```[a-z]*\n(.*?)```|((?:^    .*\n)+)", text.replace("\\\n", " "), re.DOTALL | re.MULTILINE)
    lines = [found.group(1) for block in blocks for found in COMMAND.finditer("".join(block))]
    return [line.partition(" #")[0].rstrip() for line in lines]


@by_page
def test_every_command_shown_is_one_that_the_program_has(page: Path) -> None:
    for command in commands(page.read_text()):
        words = shlex.split(command)[1:]
        if "..." in words or any(word.isupper() for word in words):
            continue  # a pattern, not a command
        try:
            parser().parse_args(words)
        except SystemExit as exit_:
            if exit_.code != 0:  # --help and --version leave with 0
                raise AssertionError(f"{page.name}: {command}") from exit_


@by_page
def test_every_link_leads_to_a_file(page: Path) -> None:
    for link in LINK.findall(page.read_text()):
        assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_a_command_that_is_not_there_would_be_found() -> None:
    assert commands("```\nhysgen polish x.csv   # shine\n```\n\n    hysgen cost c\n") == [
        "hysgen polish x.csv",
        "hysgen cost c",
    ]
    with pytest.raises(SystemExit):
        parser().parse_args(["polish", "x.csv"])


def test_reference_of_the_python_interface_names_all_of_it() -> None:
    assert sorted(hysgen.__all__) == sorted(api.__all__)
    page = (ROOT / "docs" / "api.md").read_text()
    missing = [name for name in hysgen.__all__ if not re.search(rf"\b{name}\b", page)]
    assert not missing
