"""Setting the simulated motor to the study's published numbers: ``python -m gen.rig.calibrate``."""
