"""Alarm thresholds from runs of the healthy motor: how far it is from its model, and what goes beyond.

`healthy` compares runs with the model as the board's rules will; `derive` makes error bands and the rules' missing
numbers.
"""
