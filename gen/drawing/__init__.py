"""Runs as pictures: what was measured, what a model says, what is between them, and which alarms and faults there were.

`section` says what is drawn of a run, with all its values; `interactive` makes an HTML page of it and `picture` an
SVG or PNG, each with as many points as can be seen (`thinning`).
"""
