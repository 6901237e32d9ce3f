"""Measurement uncertainty after the GUM: sensor, repeatability, simulated displacement."""
