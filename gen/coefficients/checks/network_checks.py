"""What a network must satisfy at every |PWM| of its domain before anything is built from it."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients.base import THOUSANDTHS
from gen.coefficients.checks.model_checks import FASTEST, HIGHEST, table_warning
from gen.errors import InputError
from gen.model.dynamics import ThermalModel
from gen.model.network import Network
from gen.model.network_parts import Factor

_ROOM_DEGC = 25.0
"""Ambient at which the steady rise is looked at; heat that depends on temperature depends on it."""

FEWEST_STEPS = 100
"""Of a channel over its range: with fewer one step moves what it multiplies by more than a hundredth."""


def check_network(model: ThermalModel) -> tuple[str, ...]:
    """Check signs, ways out, speed and steady state at every integer |PWM| of the domain.

    Returns
    -------
    tuple of str
        Warnings.

    Raises
    ------
    InputError
        With the JSON path; the message names node or path, and the PWM.
    """
    network = model.network
    assert network is not None
    lo, hi = model.domain_pwm
    pwm = np.arange(lo, hi + 1)
    _check_factors(network)
    _check_signs(network, pwm)
    ends = _law_ends(network, model)
    _check_reach(network, pwm, ends)
    _check_speed(network, pwm, model.sample_time, ends)
    _check_lags(network, model.sample_time)
    _check_runaway(network, pwm, ends)
    _check_rise(network, pwm)
    return _table_warnings(network, model) + _cooling_warnings(network, model) + _coarse_channels(network)


def _check_factors(network: Network) -> None:
    """A factor below 0 would turn a conductance, or a heat, round."""
    places = [(f"$.network.paths[{i}]", path.factors) for i, path in enumerate(network.paths)]
    places += [(f"$.network.heats[{i}]", heat.factors) for i, heat in enumerate(network.heats)]
    for place, factors in places:
        for k, factor in enumerate(factors):
            at = _points(network, factor)
            values = factor(at)
            if values.min() < 0.0 or not np.isfinite(values).all():
                worst = int(np.argmin(values))
                raise InputError(
                    f"the factor is {values[worst]:.4g} at {factor.channel} = {at[worst]:g}; "
                    "expected none below 0 in the channel's range",
                    place=f"{place}.factors[{k}]",
                )


def _points(network: Network, factor: Factor) -> FloatArray:
    channel = network.channel(factor.channel)
    return factor.turning_points(channel.low, channel.high)


def _extremes(network: Network, factors: tuple[Factor, ...]) -> tuple[float, float]:
    """Bounds of a product of factors, whatever the channels say: of each factor by itself."""
    values = [factor(_points(network, factor)) for factor in factors]
    return float(np.prod([v.min() for v in values])), float(np.prod([v.max() for v in values]))


def _law_ends(network: Network, model: ThermalModel) -> FloatArray:
    """Least and largest slope of each path's law between any two temperatures of the domain, 1 where it has none.

    Returns
    -------
    FloatArray
        Shape (paths, 2); none is below 0.

    Raises
    ------
    InputError
        If heat would fall somewhere as the difference grows: then nothing that is proven of a network holds.
    """
    low, high = _widest(model)
    found = np.ones((len(network.paths), 2))
    for number, law in network.laws:
        found[number] = law.slope_ends(low, high)
        if found[number, 0] < 0.0 or not np.isfinite(found[number]).all():
            raise InputError(
                f"between two temperatures of the domain, {low:g} to {high:g} degC, the heat changes by "
                f"{found[number, 0]:.4g} times the conductance for each kelvin of difference; expected that it never "
                "falls as the difference grows",
                place=f"$.network.paths[{number}].{type(law).__name__.lower()}",
            )
    return found


def _widest(model: ThermalModel) -> tuple[float, float]:
    """Ends of all temperatures that the domain names, degC."""
    ends = (*model.domain_temperature, *model.domain_ambient)
    return min(ends), max(ends)


def _check_signs(network: Network, pwm: IntArray) -> None:
    for kind, key, values in (
        ("paths", "conductance_W_per_K", network.conductances),
        ("heats", "power_W", network.powers),
    ):
        for number in range(values.shape[1]):
            own = values[pwm, number]
            bad = ~np.isfinite(own) | (own < 0.0)
            if bad.any():
                worst = int(pwm[bad][0])
                raise InputError(
                    f"found {values[worst, number]:.4g} at PWM {worst}, expected a finite value of 0 or more "
                    "everywhere in the domain",
                    place=f"$.network.{kind}[{number}].{key}",
                )


def _check_reach(network: Network, pwm: IntArray, laws: FloatArray) -> None:
    """Heat of every node finds a way to the ambient at every |PWM|, whatever the channels say."""
    least = [_extremes(network, path.factors)[0] * own for path, own in zip(network.paths, laws[:, 0], strict=True)]
    open_ = network.conductances[pwm] * np.array(least) > 0.0
    for pattern in np.unique(open_, axis=0):
        reached: set[str | None] = {None}
        ways = [(path.first, path.second) for path, is_open in zip(network.paths, pattern, strict=True) if is_open]
        while True:
            more = {end for way in ways for end in way if reached & set(way)} - reached
            if not more:
                break
            reached |= more
        for i, node in enumerate(network.nodes):
            if node.name not in reached:
                at = int(pwm[np.flatnonzero((open_ == pattern).all(axis=1))[0]])
                raise InputError(
                    f'heat of "{node.name}" has no way to the ambient at PWM {at}; expected a path with a conductance '
                    "above 0, also where its factors are smallest",
                    place=f"$.network.nodes[{i}]",
                )


def _table_warnings(network: Network, model: ThermalModel) -> tuple[str, ...]:
    curves = [(f"paths[{i}].conductance_W_per_K", path.curve) for i, path in enumerate(network.paths)]
    curves += [(f"heats[{i}].power_W", heat.curve) for i, heat in enumerate(network.heats)]
    low, high = model.validity
    warnings = []
    for place, curve in curves:
        lowest = max(low, 1) if curve.at_rest is not None else low  # rest has a value of its own
        warnings.append(table_warning(curve.turning, (lowest, high), f"$.network.{place}"))
    return tuple(warning for warning in warnings if warning is not None)


def _cooling_warnings(network: Network, model: ThermalModel) -> tuple[str, ...]:
    """Say of each heat that depends on temperature so much that it cools somewhere in the domain."""
    warnings = []
    for i, heat in enumerate(network.heats):
        share = {degC: 1.0 + heat.per_K * (degC - heat.reference) for degC in model.domain_temperature}
        worst = min(share, key=lambda degC: share[degC])
        if share[worst] < 0.0:
            none = heat.reference - 1.0 / heat.per_K
            warnings.append(
                f'$.network.heats[{i}].per_K: the heat of "{heat.node}" is none at {none:.4g} degC and negative at '
                f"{worst:g} degC, inside the domain: it would cool there"
            )
    return tuple(warnings)


def _coarse_channels(network: Network) -> tuple[str, ...]:
    """Say which channels a board is told in few steps."""
    return tuple(
        f"$.network.channels[{i}].range: a board is told {channel.column} in whole thousandths of its unit, which are "
        f"{round((channel.high - channel.low) * THOUSANDTHS)} steps over the range: write it in a smaller unit"
        for i, channel in enumerate(network.channels)
        if (channel.high - channel.low) * THOUSANDTHS < FEWEST_STEPS
    )


def _check_speed(network: Network, pwm: IntArray, sample_time: float, laws: FloatArray) -> None:
    """No node follows its neighbours too fast where its paths conduct best and its own heat holds it back least."""
    most = [_extremes(network, path.factors)[1] * own for path, own in zip(network.paths, laws[:, 1], strict=True)]
    heats = [_extremes(network, heat.factors)[heat.per_K < 0.0] for heat in network.heats]
    m, _, _ = network.matrices_with(pwm, most, heats)
    own = -np.diagonal(m, axis1=1, axis2=2) * sample_time
    if own.max(initial=0.0) > FASTEST:
        at, node = np.unravel_index(int(np.argmax(own)), own.shape)
        tau = sample_time / own[at, node]
        raise InputError(
            f'"{network.nodes[node].name}" follows its neighbours with a time constant of {tau:.3g} s at PWM '
            f"{pwm[at]}; expected at least {sample_time / FASTEST:g} s, {1 / FASTEST:g} samples: merge it with the "
            "node that it follows",
            place=f"$.network.nodes[{node}].capacity_J_per_K",
        )


def _check_lags(network: Network, sample_time: float) -> None:
    for i, node in enumerate(network.nodes):
        lag = node.sensor.lag if node.sensor is not None else 0.0
        if 0.0 < lag < sample_time / FASTEST:
            raise InputError(
                f"found {lag:g}, expected 0 or at least {sample_time / FASTEST:g}, {1 / FASTEST:g} samples",
                place=f"$.network.nodes[{i}].sensor.lag_s",
            )


def _check_runaway(network: Network, pwm: IntArray, laws: FloatArray) -> None:
    """Heat that grows with temperature stays below what flows away, at the worst of each factor by itself.

    M is the capacities' inverse times a symmetric matrix, -L + D: L grows (as a quadratic form) with every conductance,
    D with the heats that grow with temperature and against those that shrink. So M is worst where paths conduct least
    and these heats are largest and smallest. A matrix without negative entries off its diagonal is stable where
    M v = -1 has a solution v > 0: it is then minus a non-singular M-matrix (Berman and Plemmons, Nonnegative Matrices
    in the Mathematical Sciences, chapter 6, I27).
    """
    least = [_extremes(network, path.factors)[0] * own for path, own in zip(network.paths, laws[:, 0], strict=True)]
    heats = [_extremes(network, heat.factors)[heat.per_K >= 0.0] for heat in network.heats]
    m, _, f = network.matrices_with(pwm, least, heats)
    runaway = ~(_solved(-m, np.ones_like(f)) > 0.0)
    if runaway.any():
        at, node = np.unravel_index(int(np.argmax(runaway)), runaway.shape)
        raise InputError(
            f'runs away at PWM {pwm[at]}: heat at or near "{network.nodes[node].name}" grows faster with temperature '
            "than it flows away; expected a smaller per_K or larger conductances",
            place="$.network",
        )


def _check_rise(network: Network, pwm: IntArray) -> None:
    """Most heat and least conductance settle at what can be a motor; every law is the difference itself."""
    least = [_extremes(network, path.factors)[0] for path in network.paths]
    most = [_extremes(network, heat.factors)[1] for heat in network.heats]
    m, a, f = network.matrices_with(pwm, least, most)
    rise = np.linalg.solve(-m, (f + a * _ROOM_DEGC)[..., None])[..., 0] - _ROOM_DEGC
    if rise.max(initial=0.0) > HIGHEST:
        at, node = np.unravel_index(int(np.argmax(rise)), rise.shape)
        raise InputError(
            f'"{network.nodes[node].name}" settles {rise[at, node]:.4g} K over ambient at PWM {pwm[at]}; '
            f"expected at most {HIGHEST:g} K: the units of powers and conductances do not fit together",
            place="$.network",
        )


def _solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solve each, shapes (k, n, n) and (k, n); NaN for a singular one."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[..., None])[..., 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full(right.shape, np.nan)
        return np.concatenate([_solved(m, r) for m, r in zip(matrices[:, None], right[:, None], strict=True)])
