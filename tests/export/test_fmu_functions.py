"""The functions of both FMUs, called without an importer: values, bits, phases, and every refusal with its words."""

from typing import Any

import numpy as np
import pytest

from fixtures.exported_folders import NAME, model
from fixtures.fmu_calls import DISCARD, ERROR, OK, TS_S, Fmu, compiled, named, token
from hysgen.codegen import Options
from hysgen.export import Reference, inputs
from hysgen.export.base import MODES
from hysgen.model.structs import Status

STANDARDS = pytest.mark.parametrize("standard", [2, 3])


@STANDARDS
def test_an_fmu_is_instantiated_under_its_own_token_alone(standard: int) -> None:
    ffi, lib = compiled(standard).ffi, compiled(standard).lib
    call, null = lib.fmu_callbacks(), ffi.NULL
    if standard == 2:
        good = [b"a", 1, token(), b"", call, 0, 0]
        for at, bad in ((0, null), (1, 0), (2, null), (2, b"{other}"), (4, null)):
            assert lib.fmi2Instantiate(*good[:at], bad, *good[at + 1 :]) == null
        assert (ffi.string(lib.fmi2GetVersion()), ffi.string(lib.fmi2GetTypesPlatform())) == (b"2.0", b"default")
    else:
        for bad in (null, b"{other}"):
            rest = (b"", False, False, False, False, null, 0, null, call, null)
            assert lib.fmi3InstantiateCoSimulation(b"a", bad, *rest) == null
        assert lib.fmi3InstantiateModelExchange(b"a", token(), b"", False, False, null, call) == null
        assert ffi.string(lib.fmi3GetVersion()).startswith(b"3.0")
    Fmu(standard).call("FreeInstance")
    getattr(lib, f"fmi{standard}FreeInstance")(null)


@STANDARDS
def test_every_variable_starts_with_what_its_description_says_also_after_a_reset(standard: int) -> None:
    fmu = Fmu(standard)
    for _ in range(2):
        for variable in named().values():
            if variable.start is not None:
                start = {"true": 1.0, "false": 0.0}.get(variable.start)
                expected = np.float32(float(variable.start)) if start is None else start
                assert fmu.get(variable.name) == expected, variable.name
        assert fmu.get("y_model_um") == fmu.get("y0_um") == fmu.get("y_um")
        assert fmu.get("u_command_V") == fmu.get("u0_V") == fmu.get("u_V")
        assert fmu.begin(y0_um=fmu.get("y0_um") + 0.125, u0_V=30.5, commit=True) == OK
        assert fmu.get("u_command_V") == 30.5
        fmu.set(u_V=41.0, y_um=2.0)
        if standard == 3:
            fmu.call("EnterStepMode")
        assert fmu.steps(3) == OK
        assert fmu.call("Reset") == OK
        assert fmu.steps() == ERROR


@STANDARDS
@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
def test_each_mode_has_the_bits_of_the_component(mode: Any, standard: int) -> None:
    reference = Reference.compile(model(), Options())
    samples = inputs(reference, mode, 600)
    fmu = Fmu(standard)
    assert fmu.begin(mode=mode.number, y0_um=float(samples.y0_um), u0_V=float(samples.u0_V)) == OK
    value, result = ("y_next_um", "u_command_V") if mode.name == "inverse" else ("u_V", "y_model_um")
    channels = [each.reference for each in named().values() if each.member.startswith("aux[")]
    out, answers = np.empty((600, 2), np.uint32), set()
    for k, row in enumerate(samples.rows[:, :-1].copy().view(np.float32).astype(float).tolist()):
        fmu.put("float", dict(zip([named()["y_um"].reference, named()[value].reference, *channels], row, strict=True)))
        fmu.set(commit=bool(samples.commit[k]))
        assert fmu.steps() == OK
        out[k] = np.float32(fmu.get(result)).view(np.uint32), int(fmu.get("status")) & 0xFFFFFFFF
        answers.add(int(fmu.get("answer")))
    assert np.array_equal(out, reference.run(samples))
    assert answers >= {0, 1} if mode.name == "learn" else answers == {0}


@STANDARDS
def test_an_input_beyond_its_range_shows_as_the_accepted_one_and_as_a_bit(standard: int) -> None:
    fmu = Fmu(standard)
    assert fmu.begin() == OK
    assert (fmu.get("u_clamped"), fmu.get("status")) == (0, 0)
    fmu.set(u_V=1e6)
    assert fmu.steps() == OK
    assert fmu.get("u_command_V") == np.float32(model().u_max_V)
    assert int(fmu.get("status")) & Status.U_CLAMPED
    bits = {name: fmu.get(name) for name, each in named().items() if each.mask}
    assert bits == {name: bool(int(fmu.get("status")) & int(named()[name].mask[:-1], 16)) for name in bits}
    assert bits["u_clamped"]
    assert not all(bits.values())


@STANDARDS
def test_a_step_is_a_whole_number_of_samples_within_a_millionth(standard: int) -> None:
    fmu, lib = Fmu(standard), compiled(standard).lib
    samples = getattr(lib, f"{NAME}_fmu_samples")
    for n in (1, 2, 3, 1000, 4_000_000_000):
        for part in (1.0, 1.0 + 0.9e-6, 1.0 - 0.9e-6):
            assert samples(n * TS_S * part) == pytest.approx(n * part, rel=2e-9, abs=1e-3)
        for part in (1.0 + 1.2e-6, 1.0 - 1.2e-6):
            assert samples(n * TS_S * part) in (0, round(n * part) if n > 400_000 else 0)
    for wrong in (0.0, -1.0, 0.4, 0.5, 1.5, 4294967296.0, 1e300, float("nan"), float("inf")):
        assert samples(wrong * TS_S) == 0, wrong
    single = Fmu(standard)
    for each in (fmu, single):
        assert each.begin() == OK
        each.set(u_V=77.0)
    assert [single.steps() for _ in range(5)] == [OK] * 5
    assert fmu.steps(5) == OK
    assert fmu.get("y_model_um") == single.get("y_model_um") != fmu.get("y0_um")
    fmu.refuses(fmu.steps(1.5), f"fmi{standard}DoStep: the step is no multiple of {1e6 * TS_S:g} us")
    assert fmu.get("y_model_um") == single.get("y_model_um")


@STANDARDS
def test_a_step_before_the_initialisation_and_after_the_end_is_refused(standard: int) -> None:
    fmu = Fmu(standard)
    words = f"fmi{standard}DoStep: " + ("not initialised" if standard == 2 else "not in step mode")
    fmu.refuses(fmu.steps(), words)
    fmu.enter()
    fmu.refuses(fmu.steps(), words)
    assert fmu.begin() == OK
    assert fmu.steps() == OK
    assert fmu.call("Terminate") == OK
    fmu.refuses(fmu.steps(), words)
    other = Fmu(standard)
    other.refuses(other.begin(mode=9), "the model does not have this mode")


@STANDARDS
def test_variables_are_reached_by_kind_in_order_and_only_inputs_and_parameters_are_set(standard: int) -> None:
    fmu, prefix = Fmu(standard), f"fmi{standard}"
    y, u = named()["y_um"].reference, named()["u_V"].reference
    assert fmu.put("float", {u: 33.5, y: 1.25}) == OK
    assert fmu.take("float", [y, u]) == (OK, [1.25, 33.5])
    for value in (1, 0):
        fmu.set(commit=value)
        assert fmu.get("commit") == value
    fmu.set(mode=3)
    assert fmu.get("mode") == 3
    assert fmu.said == ""
    words = {"float": "Real" if standard == 2 else "Float32", "word": "Integer" if standard == 2 else "UInt32"}
    outputs = {"float": "y_model_um", "word": "status", "boolean": "u_clamped"}
    for kind, name in (*words.items(), ("boolean", "Boolean")):
        setting = "no such input" if kind == "boolean" else "no such parameter or input"
        others = [each.reference for each in named().values() if each.kind != kind and each.name != "commit"]
        for wrong in (0, len(named()) + 1, 10_000, *others):
            fmu.refuses(fmu.take(kind, [wrong])[0], f"{prefix}Get{name}: no such variable")
            fmu.refuses(fmu.put(kind, {wrong: 1}), f"{prefix}Set{name}: {setting}")
        fmu.refuses(fmu.put(kind, {named()[outputs[kind]].reference: 1}), f"{prefix}Set{name}: {setting}")
    assert fmu.take("float", []) == (OK, [])


@STANDARDS
def test_a_state_is_kept_restored_and_serialised_whole(standard: int) -> None:
    fmu, upper = Fmu(standard), "FMUstate" if standard == 2 else "FMUState"
    assert fmu.begin() == OK
    fmu.set(u_V=50.0)
    assert fmu.steps(20) == OK
    kept = fmu.ffi.new("void **")
    assert fmu.call(f"Get{upper}", kept) == OK
    at, first = kept[0], fmu.get("y_model_um")
    assert fmu.steps(5) == OK
    ahead = fmu.get("y_model_um")
    size = fmu.ffi.new("size_t *")
    assert fmu.call(f"Serialized{upper}Size", at, size) == OK
    data = fmu.ffi.new("uint8_t []", size[0] + 1)
    data[size[0]] = 77
    fmu.refuses(fmu.call(f"Serialize{upper}", at, data, size[0] - 1), f"fmi{standard}Serialize{upper}: too few bytes")
    assert fmu.call(f"Serialize{upper}", at, data, size[0]) == OK
    assert data[size[0]] == 77
    name = f"De{'S' if standard == 2 else 's'}erialize{upper}"
    back = fmu.ffi.new("void **")
    for wrong in (size[0] - 1, size[0] + 1):
        fmu.refuses(fmu.call(name, data, wrong, back), f"fmi{standard}{name}: bytes of another FMU")
        assert back[0] == fmu.ffi.NULL
    assert fmu.call(name, data, size[0], back) == OK
    for state in (at, back[0]):
        assert fmu.call(f"Set{upper}", state) == OK
        assert fmu.get("y_model_um") == first
        assert fmu.steps(5) == OK
        assert fmu.get("y_model_um") == ahead
    assert fmu.call(f"Get{upper}", kept) == OK
    assert kept[0] == at, "the memory of a state is used again"
    assert fmu.call(name, data, size[0], kept) == OK
    assert kept[0] == at
    assert fmu.call(f"Set{upper}", at) == OK
    assert fmu.get("y_model_um") == first
    assert (fmu.call(f"Free{upper}", kept), kept[0]) == (OK, fmu.ffi.NULL)
    assert (fmu.call(f"Free{upper}", kept), kept[0]) == (OK, fmu.ffi.NULL)


def test_fmi_2_says_the_last_time_and_refuses_what_it_does_not_offer() -> None:
    fmu = Fmu(2)
    assert fmu.begin() == OK
    time, flag = fmu.ffi.new("double *"), fmu.ffi.new("int *", 5)
    assert (fmu.call("GetRealStatus", 2, time), time[0]) == (OK, 7.0)
    assert fmu.step(4, at_s=8.0) == OK
    assert (fmu.call("GetRealStatus", 2, time), time[0]) == (OK, 8.0 + 4 * TS_S)
    assert (fmu.call("GetBooleanStatus", 3, flag), flag[0]) == (OK, 0)
    for kind in (0, 1, 2, 3):
        places = {"": fmu.ffi.new("fmi2Status *"), "Integer": flag, "String": fmu.ffi.NULL}
        assert [fmu.call(f"Get{name}Status", kind, place) for name, place in places.items()] == [DISCARD] * 3
    assert [fmu.call("GetRealStatus", kind, time) for kind in (0, 1, 3)] == [DISCARD] * 3
    assert [fmu.call("GetBooleanStatus", kind, flag) for kind in (0, 1, 2)] == [DISCARD] * 3
    null = fmu.ffi.NULL
    assert fmu.call("SetDebugLogging", 1, 0, null) == OK
    for name in ("GetString", "SetString"):
        assert fmu.call(name, [1], 0, null) == OK
        fmu.refuses(fmu.call(name, [1], 1, null), f"fmi2{name}: no such variable")
    fmu.refuses(fmu.call("CancelStep"), "no step is pending")
    fmu.refuses(
        fmu.call("GetDirectionalDerivative", null, 0, null, 0, null, null), "directional derivatives are not provided"
    )
    words = "inputs are held over a sample: they have no derivatives"
    fmu.refuses(fmu.call("SetRealInputDerivatives", null, 0, null, null), words)
    fmu.refuses(fmu.call("GetRealOutputDerivatives", null, 0, null, null), "outputs have no derivatives")


@pytest.mark.parametrize(("events", "early"), [(True, True), (True, False), (False, True), (False, False)])
def test_a_status_bit_of_fmi_3_is_an_event_where_events_are_used_and_ends_the_step_where_it_may(
    events: bool, early: bool
) -> None:
    fmu = Fmu(3, events=events, early=early)
    assert fmu.begin() == OK
    if events:
        fmu.refuses(fmu.step()[0], "fmi3DoStep: not in step mode")
        flags, time = fmu.ffi.new("bool [5]", [True] * 5), fmu.ffi.new("double *")
        assert fmu.call("UpdateDiscreteStates", *(flags + i for i in range(5)), time) == OK
        assert list(flags) == [False] * 5
        assert fmu.call("EnterStepMode") == OK
    assert fmu.step(10, at_s=1.0) == (OK, False, False, False, 1.0 + 10 * TS_S)
    fmu.set(u_V=1e6)
    ends = events and early
    last = 2.0 + (1 if ends else 10) * TS_S
    assert fmu.step(10, at_s=2.0) == (OK, events, False, ends, pytest.approx(last, rel=1e-12))
    assert fmu.get("u_clamped") == (not events)
    if events:
        assert fmu.call("EnterEventMode") == OK
        assert fmu.get("u_clamped")
        fmu.refuses(fmu.step()[0], "fmi3DoStep: not in step mode")
        assert fmu.call("EnterStepMode") == OK
        assert fmu.step(2, at_s=3.0)[1:4] == (False, False, False), "what is shown is no event again"


def test_fmi_3_refuses_what_it_does_not_offer_by_name() -> None:
    fmu = Fmu(3)
    fmu.refuses(fmu.call("SetTime", 1.0), "fmi3SetTime: not offered")
    fmu.refuses(fmu.call("EnterConfigurationMode"), "fmi3EnterConfigurationMode: not offered")
    assert fmu.call("SetDebugLogging", True, 0, fmu.ffi.NULL) == OK


def test_fmi_3_takes_an_empty_list_of_a_type_without_variables_and_refuses_any_other() -> None:
    fmu, null = Fmu(3), Fmu(3).ffi.NULL
    for name in ("GetFloat64", "SetFloat64", "GetString", "SetString"):
        assert fmu.call(name, null, 0, null, 0) == OK
        fmu.refuses(fmu.call(name, [1], 1, null, 1), f"fmi3{name}: no such variable")
    assert fmu.call("GetBinary", null, 0, null, null, 0) == OK
    assert fmu.call("SetClock", null, 0, null) == OK
    fmu.refuses(fmu.call("GetClock", [1], 1, null), "fmi3GetClock: no such variable")
