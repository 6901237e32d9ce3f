"""The public structs and functions of the generated header as data.

Modules that compile, call or prove generated C use this description and do not parse the text.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from hysgen.codegen.manifest import MANIFEST
from hysgen.codegen.structs import structs
from hysgen.errors import HysgenError
from hysgen.float32.learner_status import Commit
from hysgen.model.disturbances import channels_of
from hysgen.model.file import parse_model
from hysgen.model.model import Model
from hysgen.model.structs import Struct


@dataclass(frozen=True)
class Function:
    """A public function.

    name: without the model's prefix; result: C type; arguments: C declarations, the struct of the state first.
    """

    name: str
    result: str
    arguments: tuple[str, ...]

    @property
    def state(self) -> str:
        """C type of the struct of the first argument; "" without arguments."""
        return self.arguments[0].removesuffix(" *self") if self.arguments else ""

    @property
    def floats(self) -> int:
        """Number of arguments after `self` if all of them are floats, else 0."""
        rest = self.arguments[1:]
        return len(rest) if all(text.startswith("float ") for text in rest) else 0

    def prototype(self, model: str) -> str:
        """The declaration as C, without semicolon."""
        return f"{self.result} {model}_{self.name}({', '.join(self.arguments) or 'void'})"


@dataclass(frozen=True)
class Interface:
    """The public part of the C of a model: structs and functions in the order of their declaration.

    channels: number of auxiliary channels.
    """

    name: str
    structs: tuple[Struct, ...]
    functions: tuple[Function, ...]
    channels: int

    def struct(self, name: str) -> Struct:
        """The struct with the C type `name`."""
        return next(struct for struct in self.structs if struct.name == name)

    def has(self, function: str) -> bool:
        """Whether the model has the function `function`, named without the model's prefix."""
        return any(known.name == function for known in self.functions)

    @property
    def prototypes(self) -> dict[str, str]:
        """C declarations without semicolon, by function, named without the model's prefix."""
        return {function.name: function.prototype(self.name) for function in self.functions}

    def declarations(self) -> str:
        """The C declarations of structs and functions for cffi."""
        channels = f"#define {self.name.upper()}_CHANNELS {self.channels}\n" if self.channels else ""
        if self.has("commit"):
            answers = ", ".join(f"{self.name.upper()}_COMMIT_{answer.name}" for answer in Commit)
            channels += f"typedef enum {{ {answers} }} {self.name}_commit_t;\n"
        declared = "".join(f"{prototype};\n" for prototype in self.prototypes.values())
        return channels + "".join(struct.declaration() for struct in self.structs) + declared


def interface(model: Model, *, inverse: bool) -> Interface:
    """The interface of the C code that `generate` returns for `model`, with or without its inverse."""
    name, channels = model.name, len(channels_of(model.terms))
    self_t, learner = f"{name}_t *self", f"{name}_learner_t *self"
    aux = f"const float aux[{name.upper()}_CHANNELS]"
    functions = [
        Function("init", "void", (self_t, "float y_um", "float u_V")),
        Function("predict", "float", (self_t, "float y_um", "float u_V")),
        Function("simulate", "float", (self_t, "float u_V")),
    ]
    if channels:
        functions.append(Function("aux", "void", (self_t, aux)))
    if inverse:
        functions.append(Function("limits", "void", (self_t, "float low_V", "float high_V", "float step_V")))
        functions.append(Function("inverse", "float", (self_t, "float y_um", "float y_next_um")))
    if model.learner:
        functions.append(Function("learn_init", "void", (learner, f"const {name}_t *model")))
        functions.append(Function("learn", "void", (learner, "float y_um", "float u_V")))
        if channels:
            functions.append(Function("learn_aux", "void", (learner, aux)))
        functions.append(Function("commit", f"{name}_commit_t", (self_t, f"{name}_learner_t *learner")))
    functions.append(Function("selftest", "uint32_t", ()))
    return Interface(name, structs(model), tuple(functions), channels)


def interface_of(name: str, texts: Mapping[str, str]) -> Interface:
    """The interface of generated `texts`, from the model file and the options in the manifest.

    Raises HysgenError if either file is missing or malformed.
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
