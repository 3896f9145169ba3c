"""Every figure and picture of the docs, by one command: ``python -m docs.figures``.

A picture carries the numbers that it shows; `tests/docs/test_figures.py` computes them again, and so sees
when a picture is out of date, whatever version of the plotting library drew it.
"""
