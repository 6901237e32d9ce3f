"""Members of a C struct, read from the text that declares it: what there is to copy."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from hysgen.errors import HysgenError

_COMMENT: Final = re.compile(r"/\*.*?\*/", re.DOTALL)
_MEMBER: Final = re.compile(r"(?:float|uint32_t) (\w+)((?:\[\d+\]){0,2})$")


@dataclass(frozen=True)
class Member:
    """A scalar, or an array of one or two `sizes`."""

    name: str
    sizes: tuple[int, ...]


def members(declaration: str) -> list[Member]:
    """The members of the struct that `declaration` declares, in its order.

    >>> members("typedef struct {\\n    float play[3];  /**< [V] */\\n    uint32_t newest;\\n} plays_t;")
    [Member(name='play', sizes=(3,)), Member(name='newest', sizes=())]

    Raises HysgenError for a member of another type, of more than two sizes, or of a size that is not a number.
    """
    _, _, rest = _COMMENT.sub("", declaration).partition("{")
    lines = [line.strip() for line in rest.partition("}")[0].split(";")]
    return [_member(line) for line in lines if line]


def _member(text: str) -> Member:
    found = _MEMBER.match(text)
    if found is None:
        raise HysgenError(f"state of a term or block: {text}: write float or uint32_t, a name, and sizes as numbers")
    return Member(found[1], tuple(int(size) for size in re.findall(r"\d+", found[2])))
