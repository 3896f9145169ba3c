"""Random motors as networks of heat capacities, and what loggers write of them: plants that judge identification.

Physics, profiles, rooms and sensors are written here anew, on numpy and scipy alone: nothing of `gen` is imported, and
no form is taken from it, so that what reads the files cannot be flattered by what wrote them.
"""
