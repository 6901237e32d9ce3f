"""The causes, DESIGN.md section 7: the names used in code, JSON, reports and tests."""

from __future__ import annotations

VOCABULARY = (
    "memory",
    "creep",
    "resonance",
    "delay",
    "saturation",
    "slew",
    "drift",
    "periodic",
    "aging",
    "outliers",
    "coupling",
    "unknown",
)
