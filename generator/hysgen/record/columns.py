"""Description of a file: columns of time, voltage and displacement, their units, separator and decimal sign."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Quantities
from hysgen.errors import RecordError, nearest

VOCABULARY: dict[str, Any] = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
"""Words by which columns, units and settings of a file are recognised."""

# Each unit as (multiply by, divide by), so that 1500 nm becomes exactly 1.5 um and not 1500 * 0.001.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "time": {"s": (1.0, 1.0), "ms": (1.0, 1e3), "us": (1.0, 1e6), "ns": (1.0, 1e9), "min": (60.0, 1.0)},
    "voltage": {"V": (1.0, 1.0), "mV": (1.0, 1e3), "uV": (1.0, 1e6), "kV": (1e3, 1.0)},
    "displacement": {
        "um": (1.0, 1.0),
        "nm": (1.0, 1e3),
        "pm": (1.0, 1e6),
        "angstrom": (1.0, 1e4),
        "mm": (1e3, 1.0),
        "m": (1e6, 1.0),
    },
}
OWN = {"time": "time_s", "voltage": "voltage_V", "displacement": "displacement_um"}
"""Names of the columns in hysgen's own files."""
NONE = "\0"
"""Name of a column that no file has, where one of both quantities is wanted."""
IN_WORDS = {word: unit for unit, words in VOCABULARY["units"].items() for word in words.split()}
"""Units in full, lower case."""
_NUMBERS: dict[str, tuple[type, str]] = {
    "Ts_s": (float, "is not a number; give seconds, as 2e-5"),
    "shift": (int, "is no whole number; give rows, as 1 or -20"),
}
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}


@dataclass(frozen=True)
class Columns:
    """Names, units and separators of a file.

    time, voltage, displacement: names of the columns (CSV) or arrays (NPZ, MAT, HDF5; there also a path "group/name",
        and a selection "u[:,0,:,:]": the first ':' is the time axis, each further ':' an axis of segments, a number an
        index). time = "" ignores any time column; then Ts_s must be given. The other two, "": as in hysgen's own files.
    time_unit, voltage_unit, displacement_unit: None takes the unit that ends the name ("x_nm" is nm), else s, V, um.
        A number before the unit is what one in the file is: "10um" for a sensor of 10 um a volt, "-1um" for an inverted
        one, "100V" for a monitor of 1:100.
    input, output: two other quantities in the columns voltage and displacement, each with its unit, as "field [mT]" and
        "angle [deg]"; both or none. hysgen's own files call these columns field_mT and angle_deg.
    segment: column or array with the number of the unbroken run; used if the file has it.
    aux: further channels to read, each "name" or "new_name=name"; None reads every other numeric column, () reads none.
    separator: one character, or comma, semicolon, tab, space; None detects it in the header.
    decimal: "." or ","; None means a comma if commas are not the separator and the first row has one in a number.
    Ts_s: sampling period in s, for files without time; with a time column both must agree.
    shift: rows by which the displacement is taken later than it was written; negative: earlier. The rows at the ends
        that then lack one of both are left out. Further channels stay with the voltage.

    Raises RecordError for an unknown unit, a separator that is not one character, or a period that is not positive.
    """

    time: str = "time_s"
    voltage: str = ""
    displacement: str = ""
    time_unit: str | None = None
    voltage_unit: str | None = None
    displacement_unit: str | None = None
    input: str | None = None
    output: str | None = None
    segment: str = "segment"
    aux: tuple[str, ...] | None = None
    separator: str | None = None
    decimal: str | None = None
    Ts_s: float | None = None
    shift: int = 0

    def __post_init__(self) -> None:
        if (self.input is None) != (self.output is None):
            raise RecordError("columns: input and output are given together, as input=field [mT],output=angle [deg]")
        for role, own in zip(("voltage", "displacement"), self.quantities.columns, strict=True):
            object.__setattr__(self, role, getattr(self, role) or own)
        for role in UNITS:
            unit = getattr(self, f"{role}_unit")
            if unit is not None and conversion(self.units_of(role), unit) is None:
                raise RecordError(
                    f"{role}_unit: '{unit}' is not known; choose from {', '.join(self.units_of(role))}, or give what "
                    f"one in the file is, as 10{self.base(role)}"
                )
        if self.separator is not None and len(SEPARATORS.get(self.separator, self.separator)) != 1:
            raise RecordError(
                f"separator: '{self.separator}' is not one character; choose from {', '.join(SEPARATORS)}, or give one"
            )
        if self.decimal not in (None, ".", ","):
            raise RecordError(f"decimal: '{self.decimal}' is not known; choose '.' or ','")
        if self.Ts_s is not None and not (math.isfinite(self.Ts_s) and self.Ts_s > 0.0):
            raise RecordError(f"Ts_s: {self.Ts_s:g} s is no sampling period; give a positive number of seconds")

    @classmethod
    def from_text(cls, text: str) -> Columns:
        """Columns from "key=value,key=value", the keys being the fields of this class; `aux` may come several times.

        Commas inside square brackets do not separate: "voltage=u[:,0],displacement=y[:,0],Ts_s=1e-4" has three pairs.
        Raises RecordError for an unknown key or a number that cannot be read.
        """
        known = [one.name for one in fields(cls)]
        given: dict[str, Any] = {}
        pairs: list[str] = []
        for part in re.findall(r"(?:\[[^\]]*\]|[^,\[])+", text):
            # A name may hold a comma: "voltage=Voltage, V".
            if pairs and "=" not in part and "=" in pairs[-1] and part.strip() not in known:
                pairs[-1] += f",{part}"
            else:
                pairs.append(part)
        for pair in pairs:
            key, equals, value = (part.strip() for part in pair.partition("="))
            if key in known and not equals:
                raise RecordError(f"columns: '{key}' has no value; write {key}=NAME")
            if key not in known:
                raise RecordError(
                    f"columns: '{pair.strip()}' is not understood{nearest(key, known)}; "
                    f"write key=value with a key out of {', '.join(known)}"
                )
            if key == "aux":
                given["aux"] = given.get("aux", ()) + ((value,) if value else ())
            elif key in _NUMBERS:
                kind, what = _NUMBERS[key]
                try:
                    given[key] = kind(value)
                except ValueError:
                    raise RecordError(f"columns: {key} '{value}' {what}") from None
            else:
                given[key] = value
        return cls(**given)

    def of(self, quantities: Quantities) -> Columns:
        """The columns for a file of these quantities, if none are stated."""
        if self.quantities.other or not quantities.other:
            return self
        q, (voltage, displacement) = quantities, self.quantities.columns
        return replace(
            self,
            input=f"{q.input} [{q.input_unit}]",
            output=f"{q.output} [{q.output_unit}]",
            voltage="" if self.voltage == voltage else self.voltage,
            displacement="" if self.displacement == displacement else self.displacement,
        )

    def named(self, names: Mapping[str, str], units: Mapping[str, str] | None = None) -> Columns:
        """The columns with these names and units by role."""
        fields: dict[str, Any] = {**names, **{f"{role}_unit": unit for role, unit in (units or {}).items()}}
        return replace(self, **fields)

    @property
    def quantities(self) -> Quantities:
        """What stands in the columns voltage and displacement."""
        return Quantities() if self.input is None or self.output is None else Quantities.of(self.input, self.output)

    def units_of(self, role: str) -> Mapping[str, tuple[float, float]]:
        """The units of `role`, each as (multiply by, divide by): of another quantity than hysgen's own, one."""
        stated = self.quantities
        other = {"voltage": stated.input_unit, "displacement": stated.output_unit}
        return {other[role]: (1.0, 1.0)} if stated.other and role in other else UNITS[role]

    def base(self, role: str) -> str:
        """The unit in which `role` is computed: s, V, um, or that of another quantity."""
        return next(unit for unit, scale in self.units_of(role).items() if scale == (1.0, 1.0))

    def unit(self, role: str) -> str:
        """Unit of `role` ("time", "voltage", "displacement"): as given, else the suffix of its name, else s, V, um."""
        given = getattr(self, f"{role}_unit")
        if given is not None:
            return self.plain(role, given)
        return self.unit_in_name(role) or self.base(role)

    def plain(self, role: str, unit: str) -> str:
        """The unit of `role` in the spelling of `units_of`."""
        return _known(self.units_of(role), unit)

    def unit_in_name(self, role: str) -> str | None:
        """Unit in the suffix of the column's name, as in "x_nm", "x [nm]" or "x (nm)"; None without a unit.

        Raises RecordError for a unit of another quantity or one that is not known, as "Position (%)".
        """
        name = re.sub(r"\[[^\]]*[:,][^\]]*\]$", "", getattr(self, role))
        _, text = split_unit(name)
        bracketed = name.rstrip().endswith(("]", ")", ">"))
        # "u_in" is an input, and a time may count steps or ticks.
        if self.quantities.other and role != "time" and not bracketed:  # of free units, a bare ending says nothing
            text = name.rpartition("_")[2] if name.rpartition("_")[2] == self.base(role) else text
        elif text is not None and not bracketed and plain_unit(text) not in UNITS[role] and role_may_end_in(role, text):
            return None
        if text is None:
            return None
        self.check_unit(role, text)
        return self.plain(role, text)

    def check_unit(self, role: str, unit: str, source: str = "") -> None:
        """Raises RecordError for a unit in a name or in a row of units that is none of the role's."""
        if self.plain(role, unit) not in self.units_of(role):
            name, base = getattr(self, role), self.base(role)
            unit = f"'{unit}'" if self.quantities.other else unit
            scaled = f"; if one {unit} is 10 {base}, {role}_unit=10{base}" if role != "time" else ""
            if role != "time" and not self.quantities.other:
                scaled += "; if it is another quantity, say both, as input=field [mT],output=angle [deg]"
            where = f"{source}: " if source else ""
            raise RecordError(
                f"{where}the {role} '{name}' is in {unit}, which is no unit of a {role}; if it is in {base} "
                f'all the same, give --columns "{role}={name},{role}_unit={base}"{scaled}'
            )

    def in_base_unit(self, role: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """`values` of `role` in s, V or um."""
        multiply, divide = self.scale(role)
        return values if multiply == divide else values * multiply / divide

    def scale(self, role: str) -> tuple[float, float]:
        """(multiply by, divide by) from the unit of `role` in the file to s, V or um."""
        return conversion(self.units_of(role), self.unit(role)) or (1.0, 1.0)

    def aux_pairs(self) -> tuple[tuple[str, str], ...] | None:
        """(name in the record, name in the file) of the requested further channels; None if `aux` is None."""
        if self.aux is None:
            return None
        pairs = ((text if "=" in text else f"{text}={text}").partition("=") for text in self.aux)
        return tuple((label.strip(), name.strip()) for label, _, name in pairs)

    def remarks(self) -> tuple[str, ...]:
        """A line for each unit that comes from a column's name and is not the base unit."""
        return tuple(
            f"{getattr(self, role)} is read in {unit}, as its name says; give {role}_unit if that is wrong"
            for role in UNITS
            if getattr(self, f"{role}_unit") is None
            and (unit := self.unit_in_name(role)) is not None
            and unit != self.base(role)
        )


def plain_unit(unit: str) -> str:
    """The unit in the spelling of UNITS: the micro sign as u, words in full, capitals where they are common.

    >>> [plain_unit(text) for text in ("\N{MICRO SIGN}m", "micron", "Volts", "sec", "NM")]
    ['um', 'um', 'V', 's', 'nm']
    """
    text = unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u").strip()
    known = {one for units in UNITS.values() for one in units}
    if text in known:
        return text
    lower = text.lower()
    return IN_WORDS.get(lower) or {one.lower(): one for one in known}.get(lower, text)


_SCALED = re.compile(r"([-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)\s*([^\d\s/.]+)(?:\s*/\s*\S+)?")


def conversion(units: Mapping[str, tuple[float, float]], unit: str) -> tuple[float, float] | None:
    """(multiply by, divide by) from a unit among `units`, perhaps with a number before it; None for any other.

    >>> lengths = UNITS["displacement"]
    >>> conversion(lengths, "nm"), conversion(lengths, "2.5 um/V"), conversion(UNITS["voltage"], "m")
    ((1.0, 1000.0), (2.5, 1.0), None)
    """
    if (plain := _known(units, unit)) in units:
        return units[plain]
    scaled = _SCALED.fullmatch(unit.strip())
    if scaled is None or float(scaled.group(1)) == 0.0 or (plain := _known(units, scaled.group(2))) not in units:
        return None
    multiply, divide = units[plain]
    return float(scaled.group(1)) * multiply, divide


def _known(units: Mapping[str, Any], unit: str) -> str:
    """A unit in the spelling of `units`."""
    return unit.strip() if unit.strip() in units else plain_unit(unit)


_ENDING = re.compile(r"(.+?)(?:(?:_|\s*/\s*|\s+in\s+|\s+)([^\s_/]+)|(?<=[a-z])(?!In$|Min$)([A-Z][a-z]+))")
"""A name and what may be its unit: x_nm, x / nm, x in nm, x nm, positionCounts."""

_OTHER_UNITS = re.compile(
    r"(?i:counts?|cnts?|cts|raw|adc|dac|\d*(?:lsbs?|bits?)\d*|codes?|digits?|dig|pulses|ticks?|steps?|px|pix|pixels?"
    r"|fringes?|orders?|revs?|turns|per_?cent|pct|pp[mb]|%|%fs|fs|norm|normali[sz]ed|a\.?u\.?|arb|in|thou|mils?|ft|feet"
    r"|yards?|[um\N{MICRO SIGN}]in|(?:[num\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}ckM]|micro|milli|nano|kilo|mega)?"
    r"(?:rad|deg|grad|hz|bar|psi|ohm|strain|eps|newton|amps?|inch(?:es)?|watt|counts?|pascal|radians?|degrees?)"
    r"|degc|d[bB][vm]?|arc_?(?:sec|min)|asec|mpa|kpa|hpa|duty|pwm)"
    r"|[pnumk]A|[unmk]N|[munp]C|[mk]?W|m?K"
)
"""Units of other quantities that end a name: no stage moves by a percent or a count before its size is said."""


def role_may_end_in(role: str, unit: str) -> bool:
    """Whether the name of a role may end in the spelling of a unit that is none of the role's."""
    return role == "time" or (role == "voltage" and unit == "in")


def split_unit(name: str) -> tuple[str, str | None]:
    """A column's name without its unit, and the unit; None if the name has none.

    In brackets, every text is a unit; behind "_", "/", "in", a blank, or with a capital, only one that is known.

    >>> [split_unit(text) for text in ("Sensor 1 [nm]", "x_nm", "U in V", "displacement_raw", "Position (%)")]
    [('Sensor 1', 'nm'), ('x', 'nm'), ('U', 'V'), ('displacement', 'raw'), ('Position', '%')]
    """
    text = re.sub(r"(?<=[\])>])\.\d+$", "", name.strip())
    bracketed = re.fullmatch(r"(.*?)[\s_]*(?:\[([^\[\]:,]*)\]|\(([^()]*)\)|<([^<>]*)>)", text)
    if bracketed and not re.fullmatch(r"-?\d+", unit := next(one for one in bracketed.groups()[1:] if one is not None)):
        return bracketed.group(1), unit.strip() or None
    if ending := _ENDING.fullmatch(text):
        unit = ending.group(2) or ending.group(3)
        if any(plain_unit(unit) in units for units in UNITS.values()) or _OTHER_UNITS.fullmatch(unit):
            return ending.group(1), unit
    return text, None


def agreed(source: str, name: str, stated: Mapping[str, str | None]) -> str | None:
    """The last unit that is stated of a column. Raises RecordError if its name, or what is stated before, differs."""
    named = split_unit(name)[1]
    known = named and any(plain_unit(named) in units for units in UNITS.values())
    said = [("its name", named)] if named and known else []
    said += [(where, unit) for where, unit in stated.items() if unit]
    for (first, one), (second, other) in pairwise(said):
        if plain_unit(one) != plain_unit(other):
            raise RecordError(
                f"{source}: {name} is in {one} by {first} and in {other} by {second}; correct one of the two"
            )
    return said[-1][1] if said and said[-1][0] != "its name" else None
