"""The generated C on other instruction sets, run by qemu: the same bits, both orders of bytes."""
