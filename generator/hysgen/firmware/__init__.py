"""The firmware around the generated code: its parameter images, its host image, what it tracks, what it costs."""
