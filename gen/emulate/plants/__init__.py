"""What heats at the other end of the pins: the rig, a model's own plant with faults and effects, and its twin."""
