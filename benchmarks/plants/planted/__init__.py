"""What is otherwise on a bench in later runs than in those that identified the motor: physics, surroundings, sensors.

Each change is written as an engineer would describe it, in forms that what reads the files does not have: a fan cools
by a correlation for a cylinder in cross flow, grease thins exponentially, a load is a torque. Nothing of `gen` is
imported.
"""
