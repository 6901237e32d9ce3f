"""Results for readers: a diagnosis as text, HTML pages that need no other file, pictures."""

BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#e69f00", "#009e73", "#cc79a7"
SKY, YELLOW, VERMILION = "#56b4e9", "#f0e442", "#d55e00"
"""Okabe and Ito (2008), "Color Universal Design": distinct for all common kinds of colour blindness."""
