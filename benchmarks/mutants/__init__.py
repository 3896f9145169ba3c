"""Small defects planted into ``gen/`` and ``templates/``, one at a time: do the nearest tests see them?

``python -m benchmarks.mutants record`` notes once which test runs which line; then
``python -m benchmarks.mutants run --count 300`` plants, tests and prints the score and what survived.
"""
