"""The ATmega2560: compiling for it, and running what was compiled on libsimavr.

`compile` makes ELF files and reads their symbols and sizes; `simulator` runs them (its C half is ``shim.c``);
``mailbox.h`` is what a harness ``main`` includes to take inputs from `EmulatedMega.run_records`.
"""
