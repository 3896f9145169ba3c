"""What the calibration may move: a first guess with its uncertainty, and bounds outside which it is no such motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.rig.parameters import AMBIENT, NODES, MotorParameters


@dataclass(frozen=True)
class Unknown:
    """One parameter: ``group.key``, first guess, standard deviation of its logarithm, lower and upper bound."""

    name: str
    guess: float
    spread: float
    low: float
    high: float


#: 2 kg of motor: some 0.6 kg of copper and iron in the armature, 0.25 kg of ferrite, 0.9 kg of steel in yoke and end
#: shields, at 390, 800 and 460 J/(kg K); brushes with their holder plate; one bearing with its seat. Conductances from
#: areas (casing 0.05 m2, armature 0.03 m2) and 5..10 W/(m2 K) at rest; the shaft conducts 0.03..0.1 W/K to a bearing.
UNKNOWNS = (
    Unknown("capacity.winding", 240, 0.2, 150, 320),
    Unknown("capacity.brush", 80, 0.3, 20, 150),
    Unknown("capacity.bearing", 30, 0.3, 15, 80),
    Unknown("capacity.magnet", 180, 0.2, 100, 250),
    Unknown("capacity.casing", 400, 0.2, 270, 550),
    Unknown("still.winding-air", 0.3, 0.6, 0.12, 3),
    Unknown("forced.winding-air", 1.5, 0.5, 0.3, 5),
    Unknown("still.brush-winding", 0.02, 0.4, 0.005, 0.05),
    Unknown("still.brush-air", 0.03, 0.5, 0.01, 0.2),
    Unknown("forced.brush-air", 0.05, 0.5, 0.005, 0.3),
    Unknown("still.brush-casing", 0.05, 0.4, 0.015, 0.3),
    Unknown("still.winding-bearing", 0.06, 0.4, 0.03, 0.15),
    Unknown("still.bearing-casing", 1.0, 0.5, 0.2, 5),
    Unknown("still.magnet-casing", 4.0, 0.5, 0.5, 20),
    Unknown("still.magnet-air", 0.2, 0.6, 0.03, 2),
    Unknown("forced.magnet-air", 0.7, 0.5, 0.03, 3),
    Unknown("still.air-casing", 0.25, 0.6, 0.12, 3),
    Unknown("forced.air-casing", 3.0, 0.5, 0.1, 10),
    Unknown("still.casing-ambient", 0.25, 0.3, 0.15, 0.5),
    Unknown("forced.casing-ambient", 0.15, 0.6, 0.02, 0.6),
    Unknown("still.air-ambient", 0.01, 0.7, 0.0005, 0.1),
    Unknown("forced.air-ambient", 0.05, 1.0, 0.002, 0.3),
    Unknown("exponent.inside", 0.8, 0.15, 0.5, 1.0),
    Unknown("exponent.outside", 0.6, 0.2, 0.4, 1.0),
    Unknown("losses.brush_friction_Nm", 0.02, 0.5, 0.002, 0.06),
    Unknown("losses.brush_friction_s0", 0.6, 0.4, 0.35, 10),
    Unknown("losses.contact_drop_V", 1.2, 0.3, 0.4, 2.0),
    Unknown("losses.brush_keeps", 0.5, 0.3, 0.1, 0.7),
    Unknown("losses.bearing_dry_Nm", 0.003, 0.5, 0.0005, 0.02),
    Unknown("losses.bearing_viscous_Nm", 0.003, 0.5, 0.0002, 0.008),
    Unknown("losses.iron_hysteresis_Nm", 0.02, 0.5, 0.002, 0.05),
    Unknown("losses.iron_eddy_Nm", 0.006, 0.6, 0.0005, 0.05),
    Unknown("losses.windage_W", 0.7, 0.5, 0.1, 2.5),
    Unknown("losses.ripple_eddy_W", 5.0, 0.5, 0.1, 15),
    Unknown("losses.ripple_current_W", 3.0, 0.5, 0.1, 15),
    Unknown("losses.ripple_in_brush", 0.03, 0.5, 0.005, 0.15),
    Unknown("losses.ripple_in_magnet", 0.1, 0.4, 0.02, 0.25),
    Unknown("losses.ripple_in_casing", 0.1, 0.5, 0.01, 0.5),
    Unknown("bearing.dry_Nm", 0.03, 0.5, 0.005, 0.1),
    Unknown("bearing.rough", 0.3, 0.5, 0.01, 0.9),
    Unknown("bearing.s0", 0.3, 0.4, 0.05, 1.0),
    Unknown("bearing.skid_Nm", 0.005, 0.7, 0.0002, 0.03),
    Unknown("brush.lost", 0.35, 0.3, 0.1, 0.7),
    Unknown("brush.bounce", 0.6, 0.3, 0.05, 0.95),
    Unknown("brush.bounce_s", 0.6, 0.1, 0.4, 0.8),
    Unknown("brush.bounce_width", 0.2, 0.3, 0.05, 0.4),
    Unknown("brush.arc_W", 4.0, 0.5, 0.5, 12),
    Unknown("brush.arc_exponent", 0.8, 0.4, 0.2, 2.0),
    Unknown("brush.arc_in_casing", 0.5, 0.4, 0.05, 1.0),
    Unknown("brush.edge_W", 0.4, 0.7, 0.01, 3.0),
    Unknown("brush.edge_exponent", 4.0, 0.4, 1.0, 10.0),
)

#: Nameplate and plausible values that the published numbers do not tell apart.
ELECTRICAL = {
    "nominal_voltage_V": 24.0,
    "rated_speed_rpm": 2650.0,
    "torque_constant_Nm_per_A": 0.0865,
    "resistance_ohm": 0.35,
    "resistance_per_K": 0.0039,
    "spin_time_constant_s": 0.15,
}
#: Half a litre of air holds 0.6 J/K; the rest is the insulation and dust that follow it at once.
AIR_J_PER_K = 2.0

GUESSES: FloatArray = np.log([unknown.guess for unknown in UNKNOWNS])
SPREADS: FloatArray = np.array([unknown.spread for unknown in UNKNOWNS])
BOUNDS: tuple[FloatArray, FloatArray] = (np.log([u.low for u in UNKNOWNS]), np.log([u.high for u in UNKNOWNS]))


def motor(logarithms: FloatArray, digits: int | None = None, about: str = "") -> MotorParameters:
    """Put parameters together from the unknowns' logarithms, shape (len(UNKNOWNS),), to some significant digits."""
    groups: dict[str, dict[str, float]] = {}
    for unknown, value in zip(UNKNOWNS, np.exp(logarithms), strict=True):
        group, key = unknown.name.split(".")
        groups.setdefault(group, {})[key] = float(value if digits is None else f"{value:.{digits}g}")
    paths: list[dict[str, Any]] = []
    for ends, still in groups["still"].items():
        path: dict[str, Any] = dict(zip("ab", ends.split("-"), strict=True)) | {"still_W_per_K": still}
        if ends in groups["forced"]:
            where = "outside" if path["b"] == AMBIENT else "inside"
            path |= {"forced_W_per_K": groups["forced"][ends], "exponent": groups["exponent"][where]}
        paths.append(path)
    capacities = groups["capacity"] | {"air": AIR_J_PER_K}
    return MotorParameters.model_validate(
        {
            "about": about,
            "capacities_J_per_K": {name: capacities[name] for name in NODES},
            "paths": paths,
            "losses": groups["losses"],
            "electrical": ELECTRICAL,
            "faults": {"bearing": groups["bearing"], "brush": groups["brush"]},
        }
    )
