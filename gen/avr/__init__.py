"""The ATmega2560: compiling for it, and running what was compiled on libsimavr.

`compile` makes ELF files and reads their symbols and sizes. `simulator` runs them, with the chip's `memory`, `uart` and
`stack`; its C half are the files in ``shim/``, which `shim` builds, loads and opens.
``mailbox.h`` is what a harness ``main`` includes to take inputs from `EmulatedChip.run_records`. The board around the
chip is in `gen.emulate`.
"""
