"""The recursion in the AVR's assembly, for every shape that cannot saturate: one block for the whole sample."""
