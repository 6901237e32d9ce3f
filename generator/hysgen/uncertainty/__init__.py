"""Measurement uncertainty after the GUM: sensor, repeatability, simulated displacement, history of a stage."""
