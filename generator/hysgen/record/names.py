"""Which column of a file is time, voltage and displacement, by the words and the units in the names of its columns.

A name is split into words and a unit: "Sensor 1 [nm]" is (sensor, 1) in nm. A role is found by, in this order,

    1  the name of hysgen's own files: time_s, voltage_V, displacement_um
    2  a word of the role, in English, German, French, Chinese, Japanese or Russian
    3  a word put together of words of that role and of no other: Wegsensor, InputData, DriveVoltage
    4  the unit, in the name or in a row of units, if no other column has a unit of the role; a name may be a unit: us

Only roles that the user did not name are guessed. Two columns that suit a role equally well are refused.
"""

import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from hysgen.errors import RecordError
from hysgen.record.columns import OWN, UNITS, VOCABULARY, Columns, plain_unit, role_may_end_in, split_unit

WORDS = {role: tuple(words.split()) for role, words in VOCABULARY["roles"].items()}
"""Words of each role, the plainest first: an earlier word wins over a later one."""

ROLES = tuple(WORDS)

Entry = TypeVar("Entry")

PART = 3
"""Letters of a word that counts inside a longer one."""

WANTED = frozenset(VOCABULARY["beside"]["wanted"].split())
"""Words of a displacement that was asked for or missed, not measured: it is chosen where there is no other."""

PLAIN = frozenset(VOCABULARY["beside"]["plain"].split())
"""Words behind a name that are taken for no unit."""


def doubts(columns: Columns) -> tuple[str, ...]:
    """A line for each voltage and displacement whose name ends in a word that may be a unit."""
    lines = []
    for role in ("voltage", "displacement"):
        name = getattr(columns, role)
        if getattr(columns, f"{role}_unit") is not None or columns.unit_in_name(role) is not None:
            continue
        words = re.findall(r"[^\W_]+", re.sub(r"\[[^\]]*[:,][^\]]*\]$", "", name))
        last = words[-1] if len(words) > 1 else ""
        plain = last.lower() in PLAIN or any(map(str.isdigit, last)) or last in "xyzuvrXYZUVR"
        if not plain and not any(last.lower() in roles for roles in WORDS.values()) and not _compound(last.lower()):
            base = columns.base(role)
            lines.append(f"{name} is read in {base}; if '{last}' is its unit, say what one is: {role}_unit=10{base}")
    return tuple(lines)


def words_of(name: str) -> tuple[str, ...]:
    """The lower-case words of a name without its unit and without accents.

    >>> words_of("Déplacement_capteur [nm]")
    ('deplacement', 'capteur')
    """
    bare, _ = split_unit(name)
    text = "".join(c for c in unicodedata.normalize("NFKD", bare.lower()) if not unicodedata.combining(c))
    if text.strip() == "x_value":
        return ("x_value",)
    return tuple(re.findall(r"[^\W\d_]+\d*|\d+", text))


NOTHING: Mapping[str, str] = {}


def guessed(
    columns: Columns, names: Sequence[str], source: str, units: Mapping[str, str] = NOTHING
) -> tuple[Columns, str]:
    """The columns with every role found among `names`, and a message that states them; "" if nothing was guessed.

    A role that the user named is kept. units: of a name, from a row of units.
    Raises RecordError for a role that two columns suit equally well.
    """
    found: dict[str, str] = {}
    if len(names) < 2:
        return columns, ""
    missing = [role for role in ROLES if getattr(columns, role) == OWN[role] and OWN[role] not in names]
    taken = {getattr(columns, role) for role in ROLES if role not in missing}
    several: dict[str, list[str]] = {}
    for role in ("displacement", "voltage", "time"):
        if role not in missing or (role == "time" and columns.Ts_s is not None):
            continue
        best = _best(role, [name for name in names if name and name not in taken], units)
        if best:
            found[role] = best[0]
            taken.add(best[0])
        if role == "time" and all(one == best[0] or one.startswith(f"{best[0]}.") for one in best):
            continue  # each channel has a column of times
        if len(best) > 1:
            several[role] = best
    for role, best in several.items():
        gain = f"; another may be a further channel: aux={best[1]}" if role == "displacement" else ""
        if role == "voltage" and "displacement" in missing and "displacement" not in found:
            found["displacement"] = best[1]
            unit = split_unit(best[1])[1] or units.get(best[1], "V")
            gain = f"; of a sensor in {unit}, add what one {unit} is: displacement_unit=10um"
        raise RecordError(
            f"{source}: the {role} may be {' or '.join(repr(name) for name in best)}; "
            f"choose one: {to_paste(columns, found, names)}{gain}"
        )
    if not found:
        return columns, ""
    bare = {role: unit for role, name in found.items() if name not in units and (unit := _unit_alone(name))}
    chosen = columns.named(found, {role: unit for role, unit in bare.items() if not getattr(columns, f"{role}_unit")})
    return chosen, f"{source}: read as {to_paste(chosen, {}, names)}"


def by_place(columns: Columns, names: Sequence[str], rising: str | None) -> tuple[Columns, str]:
    """The columns without names of their own: the one that rises is time, then voltage, displacement; the option."""
    others = [name for name in names if name not in (rising, "")]
    if len(others) < 2:
        return columns, ""
    roles = {"voltage": others[0], "displacement": others[1]} | ({"time": rising} if rising else {})
    return columns.named(roles), '--columns "' + ",".join(f"{role}={name}" for role, name in roles.items()) + '"'


def to_paste(columns: Columns, found: dict[str, str], names: Sequence[str]) -> str:
    """The option that reads a file so: --columns "time=...,voltage=...,displacement=..."; "..." for unknown roles."""
    pairs = []
    for role in ROLES:
        name = found.get(role, getattr(columns, role))
        if role == "time" and columns.Ts_s is not None and name not in names:
            continue
        pairs.append(f"{role}={name if name in names else 'NAME'}")
        unit = getattr(columns, f"{role}_unit")
        if unit is not None:
            pairs.append(f"{role}_unit={unit}")
    if columns.Ts_s is not None:
        pairs.append(f"Ts_s={columns.Ts_s:g}")
    return '--columns "' + ",".join(pairs) + '"'


def roles_in(names: Sequence[str], units: Mapping[str, str] = NOTHING) -> set[str]:
    """The roles that have a column among the names."""
    return {role for role in ROLES if _best(role, [name for name in names if name], units)}


def _unit_alone(name: str) -> str:
    """The unit that is the whole name, "" if it is none; a column "min" holds a minimum.

    >>> _unit_alone("us"), _unit_alone("Millis"), _unit_alone("min"), _unit_alone("drive")
    ('us', 'ms', '', '')
    """
    unit = plain_unit(name)
    return unit if unit != "min" and any(unit in units for units in UNITS.values()) else ""


def _best(role: str, names: Sequence[str], units: Mapping[str, str]) -> list[str]:
    """The names that suit a role best: by the first of its words, else by a unit of the role."""
    own = {name: plain_unit(split_unit(name)[1] or units.get(name, "")) for name in names}
    ranked = []
    for name, unit in own.items():
        other = bool(unit) and unit not in UNITS[role] and not role_may_end_in(role, unit)
        if other and any(unit in units for units in UNITS.values()):
            continue  # a length is no voltage, whatever it is called
        ranks = [WORDS[role].index(word) for word in words_of(name) if word in WORDS[role]]
        ranks = ranks or [len(WORDS[role]) for word in words_of(name) if _compound(word) == {role}]
        if ranks:
            ranked.append((other, min(ranks), len(words_of(name)), name))
    if ranked:
        ranked = _measured(role, ranked, lambda entry: entry[-1])
        least = min(ranked)[:-1]
        return [name for *rank, name in ranked if tuple(rank) == least]
    by_unit = _measured(role, [name for name, unit in own.items() if unit in UNITS[role]], str)
    return by_unit or [name for name in names if _unit_alone(name) in UNITS[role]]


def _measured(role: str, entries: list[Entry], name_of: Callable[[Entry], str]) -> list[Entry]:
    """The entries without displacements that were asked for or missed, unless all are."""
    measured = [entry for entry in entries if role != "displacement" or not set(words_of(name_of(entry))) & WANTED]
    return measured or entries


def _compound(word: str) -> set[str]:
    """The roles whose words a longer word contains.

    >>> _compound("wegsensor"), sorted(_compound("outputvoltage"))
    ({'displacement'}, ['displacement', 'voltage'])
    """
    return {role for role, parts in WORDS.items() if any(part in word for part in parts if len(part) >= PART)}
