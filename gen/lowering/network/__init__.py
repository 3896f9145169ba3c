"""A network as the board computes it: terms, formats, ranges and the proof of its error.

Each state advances by the Taylor series of its own exponential: y1 = h (M T + f), y2 = h M y1 / 2, y3 = h M y2 / 3, ..,
T += y1 + y2 + y3 + .., where h M T is a sum over *terms*, each a rate times a difference of two temperatures. So a
sample costs as much as the network has paths, a channel that scales a path costs one product more, and nothing on the
board has to know the matrix.
"""
