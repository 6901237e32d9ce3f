"""Which column of a file is time, voltage and displacement, by the words and the units in the names of its columns.

A name is split into words and a unit: "Sensor 1 [nm]" is (sensor, 1) in nm. A role is found by, in this order,

    1  the name of hysgen's own files: time_s, voltage_V, displacement_um
    2  a word of the role, in English, German, French or Chinese
    3  a word put together of words of that role and of no other: Wegsensor, InputData, DriveVoltage
    4  the unit, if no other column has a unit of the role

Only roles that the user did not name are guessed. Two columns that suit a role equally well are refused.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

from hysgen.errors import RecordError
from hysgen.record.columns import OWN, UNITS, Columns, plain_unit, split_unit

WORDS: dict[str, tuple[str, ...]] = {
    "time": (
        "time",
        "t",
        "zeit",
        "temps",
        "时间",
        "timestamp",
        "zeitstempel",
        "horodatage",
        "clock",
        "elapsed",
        "seconds",
        "sekunden",
        "x_value",
    ),
    "voltage": (
        "voltage",
        "volt",
        "volts",
        "u",
        "spannung",
        "tension",
        "电压",
        "drive",
        "command",
        "cmd",
        "input",
        "eingang",
        "entree",
        "excitation",
        "ansteuerung",
        "commande",
        "dac",
        "ao0",
        "输入",
    ),
    "displacement": (
        "displacement",
        "position",
        "pos",
        "y",
        "weg",
        "auslenkung",
        "verschiebung",
        "deplacement",
        "位移",
        "sensor",
        "capteur",
        "output",
        "ausgang",
        "sortie",
        "stroke",
        "hub",
        "deflection",
        "travel",
        "extension",
        "elongation",
        "dehnung",
        "ai0",
        "输出",
    ),
}
"""Words of each role, the plainest first: an earlier word wins over a later one."""

ROLES = tuple(WORDS)

PART = 3
"""Letters of a word that counts inside a longer one."""

WANTED = ("target", "setpoint", "set", "demand", "desired", "reference", "soll", "sollwert", "consigne", "error")
"""Words of a displacement that was asked for or missed, not measured: it is chosen where there is no other."""


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


def guessed(columns: Columns, names: Sequence[str], source: str) -> tuple[Columns, str]:
    """The columns with every role found among `names`, and a message that states them; "" if nothing was guessed.

    A role that the user named is kept.
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
        best = _best(role, [name for name in names if name and name not in taken])
        if best:
            found[role] = best[0]
            taken.add(best[0])
        if len(best) > 1:
            several[role] = best
    for role, best in several.items():
        raise RecordError(
            f"{source}: the {role} may be {' or '.join(repr(name) for name in best)}; "
            f"choose one: {to_paste(columns, found, names)}"
        )
    if not found:
        return columns, ""
    chosen = columns.named(found)
    return chosen, f"{source}: read as {to_paste(chosen, {}, names)}"


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


def _best(role: str, names: Sequence[str]) -> list[str]:
    """The names that suit a role best: by the first of its words, else by a unit of the role."""
    ranked = []
    for name in names:
        unit = plain_unit(split_unit(name)[1] or "")
        if unit and unit not in UNITS[role] and any(unit in units for units in UNITS.values()):
            continue  # a length is no voltage, whatever it is called
        ranks = [WORDS[role].index(word) for word in words_of(name) if word in WORDS[role]]
        ranks = ranks or [len(WORDS[role]) for word in words_of(name) if _compound(word) == {role}]
        if ranks:
            ranked.append((min(ranks), len(words_of(name)), name))
    if role == "displacement":
        measured = [one for one in ranked if not set(words_of(one[2])) & set(WANTED)]
        ranked = measured or ranked
    if ranked:
        least = min(ranked)[:2]
        return [name for *rank, name in ranked if tuple(rank) == least]
    return [name for name in names if plain_unit(split_unit(name)[1] or "") in UNITS[role]]


def _compound(word: str) -> set[str]:
    """The roles whose words a longer word contains.

    >>> _compound("wegsensor"), sorted(_compound("outputvoltage"))
    ({'displacement'}, ['displacement', 'voltage'])
    """
    return {role for role, parts in WORDS.items() if any(part in word for part in parts if len(part) >= PART)}
