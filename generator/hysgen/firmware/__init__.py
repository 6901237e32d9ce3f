"""The firmware around the generated C: images for host, simulator and C6748, parameter images, tracking experiment."""
