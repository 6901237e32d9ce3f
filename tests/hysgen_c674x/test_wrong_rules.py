"""Every pipeline rule turned wrong, in the interpreter and in the engine, fails the check of that rule."""

from __future__ import annotations

import pytest

from fixtures import c674x_rules as rules
from fixtures.c674x_wrong_rules import LOOSE_LIMITS, WRONG_RULES, changed_module, notices
from hysgen_c674x import interpreter, packets, translation


@pytest.mark.parametrize("name", WRONG_RULES)
def test_every_wrong_rule_of_the_interpreter_is_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = WRONG_RULES[name]
    wrong.noticed_by(True)
    monkeypatch.setattr(interpreter, "run", changed_module(interpreter, *wrong.interpreter).run)
    assert notices(wrong.noticed_by, True)


@pytest.mark.parametrize("name", WRONG_RULES)
def test_every_wrong_rule_of_the_engine_is_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = WRONG_RULES[name]
    old, new = wrong.engine
    texts = translation.runtime()
    if any(old in text for text in texts.values()):
        changed = {file: text.replace(old, new) for file, text in texts.items()}
        monkeypatch.setattr(translation, "runtime", lambda: changed)
    else:
        monkeypatch.setattr(translation, "program", changed_module(translation, old, new).program)
    assert notices(wrong.noticed_by, False)


@pytest.mark.parametrize("interpreted", [True, False], ids=["interpreter", "engine"])
@pytest.mark.parametrize("limit", LOOSE_LIMITS)
def test_every_loose_limit_of_a_packet_is_caught(
    limit: str, interpreted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    packet, complaint = LOOSE_LIMITS[limit]

    def refused(interpreted: bool) -> None:
        rules.a_packet_beyond_the_processors_resources_is_refused(packet, complaint, interpreted)

    refused(interpreted)
    monkeypatch.setattr(packets, limit, getattr(packets, limit) + 1)
    assert notices(refused, interpreted)
