"""Ways to have the MY1016's model on an Arduino Mega, beside the generated one.

`catalogue` lists them, each with its C++ in ``sources/``; `tables`, `casadi_step` and `emlearn_net` write what of them
is generated; `programs` compiles and runs them as `gen.verification.runners` does with the emitted library; `measure`
judges all by the same profiles and the exact solution, `ours` does that with the emitted library, and `table` prints
it.
"""
