"""The complete firmware on the C674x: image, sizes, cycles, boot image."""
