"""What the source study measured on the real motor, for use as an oracle beside `tests.model.published`."""

# Table 4.1: temperatures at the end of each run, degC, at 20..100 % speed, 30 degC ambient.
MEASURED_DEGC = {
    "brush": (71.25, 79, 84.75, 78.5, 70),
    "bearing": (53.5, 65, 71, 67.25, 62),
    "magnet": (52.75, 65.25, 71.25, 67, 61.75),
    "casing": (52, 64.5, 70.5, 66.25, 60.5),
}
AMBIENT_DEGC = 30.0
DURATION_S = 10_800.0
