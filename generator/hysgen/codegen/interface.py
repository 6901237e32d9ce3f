"""What the generated header declares, as data: its structs and its functions.

`generate` gives texts; whoever compiles, calls or proves them learns from here what they hold, not from the text.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from hysgen.codegen.manifest import MANIFEST
from hysgen.codegen.structs import structs
from hysgen.errors import HysgenError
from hysgen.model.file import parse_model
from hysgen.model.model import Model
from hysgen.model.structs import Struct
from hysgen.model.terms import channels_of


@dataclass(frozen=True)
class Function:
    """A public function.

    name: without the model's prefix; result: C type; arguments: as C declares them, the struct that it steps first.
    """

    name: str
    result: str
    arguments: tuple[str, ...]

    @property
    def state(self) -> str:
        """Type of the struct that the function steps, its first argument; "" if it has none."""
        return self.arguments[0].removesuffix(" *self") if self.arguments else ""

    @property
    def floats(self) -> int:
        """How many arguments behind `self` are floats; 0 if any of them is something else."""
        rest = self.arguments[1:]
        return len(rest) if all(text.startswith("float ") for text in rest) else 0

    def prototype(self, model: str) -> str:
        """The declaration as C, without semicolon."""
        return f"{self.result} {model}_{self.name}({', '.join(self.arguments) or 'void'})"


@dataclass(frozen=True)
class Interface:
    """The public part of the C of a model: structs and functions in the order of their declaration.

    channels: how many auxiliary channels it listens to.
    """

    name: str
    structs: tuple[Struct, ...]
    functions: tuple[Function, ...]
    channels: int

    def struct(self, name: str) -> Struct:
        """The struct of that C type."""
        return next(struct for struct in self.structs if struct.name == name)

    def has(self, function: str) -> bool:
        """Whether there is a function of that name, given without the model's prefix."""
        return any(known.name == function for known in self.functions)

    @property
    def prototypes(self) -> dict[str, str]:
        """Declarations as C without semicolon, by the function's name without the model's prefix."""
        return {function.name: function.prototype(self.name) for function in self.functions}

    def declarations(self) -> str:
        """What cffi has to be told to use the structs and to call the functions."""
        channels = f"#define {self.name.upper()}_CHANNELS {self.channels}\n" if self.channels else ""
        declared = "".join(f"{prototype};\n" for prototype in self.prototypes.values())
        return channels + "".join(struct.declaration() for struct in self.structs) + declared


def interface(model: Model, *, inverse: bool) -> Interface:
    """The interface of the C that `generate` makes of a model, with or without its inverse."""
    name, channels = model.name, len(channels_of(model.terms))
    self_t, learner = f"{name}_t *self", f"{name}_learner_t *self"
    aux = f"const float aux[{name.upper()}_CHANNELS]"
    found = [
        Function("init", "void", (self_t, "float y_um", "float u_V")),
        Function("predict", "float", (self_t, "float y_um", "float u_V")),
        Function("simulate", "float", (self_t, "float u_V")),
    ]
    if channels:
        found.append(Function("aux", "void", (self_t, aux)))
    if inverse:
        found.append(Function("inverse", "float", (self_t, "float y_um", "float y_next_um")))
    if model.learner:
        found.append(Function("learn_init", "void", (learner, f"const {name}_t *model")))
        found.append(Function("learn", "void", (learner, "float y_um", "float u_V")))
        if channels:
            found.append(Function("learn_aux", "void", (learner, aux)))
        found.append(Function("commit", "uint32_t", (self_t, f"{name}_learner_t *learner")))
    found.append(Function("selftest", "uint32_t", ()))
    return Interface(name, structs(model), tuple(found), channels)


def interface_of(name: str, texts: Mapping[str, str]) -> Interface:
    """The interface of generated texts, from the model and the options among them.

    Raises HysgenError if either is missing or malformed.
    """
    file = f"{name}.json"
    try:
        model, manifest = texts[file], texts[MANIFEST]
    except KeyError as fault:
        raise HysgenError(f"{name}: {fault} belongs to the generated texts; generate the folder again") from fault
    try:
        inverse = bool(json.loads(manifest)["options"]["inverse"])
    except (ValueError, KeyError, TypeError) as fault:
        raise HysgenError(f"{MANIFEST}: names no option inverse ({fault}); generate the folder again") from fault
    return interface(parse_model(model, file), inverse=inverse)
