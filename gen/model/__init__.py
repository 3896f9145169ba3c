"""The physics: schedules, dynamics and the exact solution."""

from gen.model.dynamics import Component, Outside, Pole, ThermalModel
from gen.model.exact import ExactSolution
from gen.model.network import Network
from gen.model.network_solution import NetworkSolution
from gen.model.schedules import ExponentialSum, Polynomial, Schedule, Segment, Table

__all__ = [
    "Component",
    "ExactSolution",
    "ExponentialSum",
    "Network",
    "NetworkSolution",
    "Outside",
    "Pole",
    "Polynomial",
    "Schedule",
    "Segment",
    "Table",
    "ThermalModel",
]
