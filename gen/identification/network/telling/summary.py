"""What was found, as JSON and as text for the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from gen.identification.grades import GOOD_K, NOISES, Grade, Miss, told, worse_than
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.bins import FloatArray
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.natural import USUAL_K
from gen.identification.network.identify import NetworkFound
from gen.identification.network.left_out import each_alone
from gen.identification.network.telling.coarse import coarse
from gen.identification.network.telling.document import measured_range, rest_was_measured, turned_range
from gen.identification.network.telling.forecast import bands
from gen.identification.network.telling.resting import REST_S, rested
from gen.identification.network.telling.rises import steady_rise_title
from gen.identification.network.telling.uncertainty import Spread, Steady, spread_of, steady_of, undetermined
from gen.identification.network.used import rms_K

SETTLED = 3.0
"""Time constants that a hold has to last for its part to have settled (95 %)."""
INTERVAL = 1.96
OFFSET_SURE = 3.0
OTHERWISE = 2.0
"""Times the error from starts of its own: a run that the file misses by more begins otherwise than the file says."""
MOST_SPEEDS = 12
HEATING = ("_A", "_W", "_Nm", "_percent")
"""Ends of the names of columns that may heat a motor."""
BENDING = "bend by more than sums of powers do, as the runs ask for or as they do not exclude"
POWERS = "are sums of powers: the runs ask for none that bends more"


class Summary:
    """What there is to say of an identified network.

    Parameters
    ----------
    result
        What was identified.
    """

    def __init__(self, result: NetworkFound) -> None:
        self.result = result

    @cached_property
    def spread(self) -> Spread:
        """Uncertainty of the parameters."""
        return spread_of(self.result.found)

    @cached_property
    def speeds(self) -> list[int]:
        """|PWM| that were held for longest, increasing, without rest."""
        inputs = self.result.inputs
        time = np.bincount(inputs.level, inputs.width, inputs.levels.count)
        pwm = np.rint(inputs.levels.speed * self.result.data.full_scale).astype(np.int64)
        total = np.bincount(pwm, np.where(inputs.levels.rest < 0.5, time, 0.0))
        total[0] = 0.0
        longest = np.argsort(-total)[:MOST_SPEEDS]
        return sorted(int(p) for p in longest if total[p] > 0.0)

    @cached_property
    def steady(self) -> Steady:
        """Where the parts settle at `speeds`, then at rest."""
        return steady_of(self.result.found, self.spread, [*self.speeds, 0], self.result.data.full_scale)

    @cached_property
    def rms_K(self) -> FloatArray:
        """Of the residual, by run and part, shape (R, S), K; NaN where nothing was read."""
        return rms_K(self.result.found, self.result.residual)

    @cached_property
    def left_out_K(self) -> FloatArray:
        """Root mean square error on what was left out, by part, shape (S,), K."""
        return np.asarray(np.sqrt(np.nanmean(self.result.judged.by_fold, axis=0)))

    @property
    def moved_K(self) -> FloatArray:
        """By how much each part moves in the runs, shape (S,), K."""
        runs = self.result.data.fine
        high = np.nanmax(
            [np.nanmax(np.where(np.isfinite(r.reading), r.reading, -np.inf), axis=0) for r in runs], axis=0
        )
        low = np.nanmin([np.nanmin(np.where(np.isfinite(r.reading), r.reading, np.inf), axis=0) for r in runs], axis=0)
        return np.asarray(high - low)

    @cached_property
    def span_s(self) -> tuple[float, float]:
        """The longest time that PWM is held, and the slowest time constant at any speed measured, s."""
        result = self.result
        longest = 0.0
        for run in result.data.coarse:
            change = np.flatnonzero((np.abs(np.diff(run.speed)) > 0.02) | (np.abs(np.diff(run.rest)) > 0.5)) + 1
            ends = run.edges[np.concatenate([[0], change, [run.width.size]])]
            longest = max(longest, float(np.max(np.diff(ends))))
        low, _ = measured_range(result)
        slowest = self.steady.slowest if low == 0 else self.steady.slowest[:-1]
        return longest, float(np.max(slowest))

    @cached_property
    def noise_K(self) -> FloatArray:
        """What each sensor scatters by, root mean square over the runs that it was read in, shape (S,), K."""
        runs = self.result.data.fine
        read = np.array([run.covered.sum(axis=0) > 0.0 for run in runs])
        squares = np.where(read, np.array([run.noise_K for run in runs]) ** 2, 0.0)
        return np.asarray(np.sqrt(squares.sum(axis=0) / np.maximum(read.sum(axis=0), 1)))

    @cached_property
    def own(self) -> list[Miss]:
        """By how much each part's own runs are missed."""
        return self._misses(np.asarray(np.sqrt(np.nanmean(self.rms_K**2, axis=0))))

    @cached_property
    def left_out(self) -> list[Miss]:
        """The same on data that took no part in the fit, or in its own runs where that is more."""
        return self._misses(np.fmax([miss.error_K for miss in self.own], self.left_out_K))

    def _misses(self, errors: FloatArray) -> list[Miss]:
        of = zip(self.result.data.names, errors.tolist(), self.moved_K.tolist(), self.noise_K.tolist(), strict=True)
        return [Miss(*each) for each in of]

    @property
    def good_to_K(self) -> float | None:
        """Error of the worst part on data that took no part in the fit, K; None unless all parts are good there."""
        return None if worse_than(Grade.GOOD, self.left_out) else max(miss.error_K for miss in self.left_out)

    @property
    def verdict(self) -> str:
        """Whether the model is good to be built, in one line; the rule is `grades`'."""
        bad, fair = (worse_than(grade, self.left_out) for grade in (Grade.FAIR, Grade.GOOD))
        if bad:
            return f"Not good yet: on data that took no part in the fit it misses {told(bad)}."
        only, worst = self._only(), max(miss.error_K for miss in self.left_out)
        # What is left out there is a whole speed, which tells of what lies between speeds and not of these.
        if fair and each_alone(self.result.inputs) and not worse_than(Grade.GOOD, self.own):
            return f"Good at the measured speeds{only}. Speeds that were left out it misses: {told(fair)}."
        if fair:
            return f"Fair{only}{'. On' if only else ': on'} data that took no part in the fit it misses {told(fair)}."
        if only:
            return f"Good{only}. Data that took no part in the fit are predicted to {worst:.2g} K."
        return (
            "Good: runs that took no part in the fit are predicted, at rest and at the measured speeds, "
            f"to {worst:.2g} K (root mean square of the worst part)."
        )

    def _only(self) -> str:
        """What it is good for alone, or nothing."""
        longest, slowest = self.span_s
        if longest < SETTLED * slowest:
            return f" for changes over up to {_time(longest)}; where the parts would settle is extrapolated"
        if not rest_was_measured(self.result):
            return " while the motor turns; cooling at rest was not measured"
        return ""

    def warnings(self) -> list[str]:
        """What to look at, one sentence each."""
        result = self.result
        said = list(result.data.warnings)
        said += [
            f"{miss.name}: the network misses data that took no part in the fit by {miss.sized}, root mean square"
            for miss in worse_than(Grade.GOOD, self.left_out)
        ]
        if worse_than(Grade.GOOD, self.left_out):
            said += coarse(result.data.sources)
        longest, slowest = self.span_s
        if longest < SETTLED * slowest:
            said.append(
                f"PWM is held for {_time(longest)} at most, and the slowest part of the motor settles with a time "
                f"constant of {_time(slowest)}: the model is good for changes over up to {_time(longest)}, "
                "what lies behind is extrapolated"
            )
        if not rest_was_measured(result):
            said.append(self._rest())
        said += self._starts()
        said += self._room()
        for s, name in enumerate(result.data.names):
            offset = float(result.found.vector[result.found.structure.offsets[s]])
            sd = float(self.spread.deviation[result.found.structure.offsets[s]])
            if abs(offset) > OFFSET_SURE * sd:
                said.append(f"{name}: its sensor reads {offset:+.2f} K against the ambient's (±{INTERVAL * sd:.2f} K)")
        return said

    def _starts(self) -> list[str]:
        """Runs that the file misses, and the network would not miss if it knew how warm they begin inside."""
        own, noise = rms_K(self.result.found, self.result.found.fit.evaluated.residual), self.noise_K
        said = []
        for r, run in enumerate(self.result.data.fine):
            worse = np.where(self.rms_K[r] > np.maximum(OTHERWISE * own[r], NOISES * noise), self.rms_K[r], 0.0)
            s = int(np.argmax(worse))
            if worse[s] > GOOD_K:
                beside = "" if run.ambient_known else ", or its room was not the one that is taken"
                said.append(
                    f"{run.name}: {self.result.data.names[s]} is followed to {own[r, s]:.2g} K, but from where the "
                    f"file lets the motor begin to {worse[s]:.2g} K: it begins warmer or colder inside than its "
                    f"sensors tell{beside}; runs that begin cold need no such guess"
                )
        return said

    def _rest(self) -> str:
        result = self.result
        told = rested(result.found, self.spread, turned_range(result), result.data.full_scale)
        return (
            "PWM 0 was not held: how the motor cools at rest is taken from its speeds, and what is forecast of a stop "
            f"among holds is uncertain by {told.now_K:.1f} K (standard deviation); {REST_S / 60.0:.0f} minutes at "
            f"PWM 0 after a run at PWM {told.pwm} would bring that to {told.then_K:.1f} K"
        )

    def _room(self) -> list[str]:
        data, problem = self.result.data, self.result.found.problem
        if data.ambient_measured:
            return []
        own = problem.per_run(self.result.found.vector)[:, problem.structure.nodes :]
        unknown = [r for r, run in enumerate(data.fine) if not run.ambient_known]
        if data.ambient_unsure_K > 0.0:
            return [
                f"nothing says the ambient: the runs themselves say {data.ambient_fixed:.1f} degC "
                f"(±{INTERVAL * data.ambient_unsure_K:.1f} K), and that is taken; log it, or give --ambient"
            ]
        most = float(np.max(np.abs(own[unknown]))) if own.size and unknown else 0.0
        return [
            f"the room was not measured in {len(unknown)} run(s): {data.ambient_fixed:.1f} degC is taken, and what the "
            f"runs show beside it (up to {most:.1f} K) is no part of the model; a room that moves moves the parts"
        ]

    def as_json(self) -> dict[str, Any]:
        """Everything as plain numbers and words."""
        result = self.result
        structure = result.found.structure
        names = (*structure.names, "ambient")
        longest, slowest = self.span_s
        return {
            "model": "network",
            "runs": [source.path for source in result.data.sources],
            "ambient": {
                "fixed_degC": result.data.ambient_fixed,
                "measured": result.data.ambient_measured,
                "unsure_K": result.data.ambient_unsure_K,
            },
            "verdict": self.verdict,
            "warnings": self.warnings(),
            "hidden_nodes": structure.hidden,
            "curves_bend": structure.bend == BEND,
            "natural_convection": self._natural(),
            "candidates": [vars(candidate) for candidate in result.candidates],
            "left_out_K": result.judged.score_K,
            "longest_hold_s": longest,
            "slowest_time_constant_s": slowest,
            "components": {name: self._component(s) for s, name in enumerate(result.data.names)},
            "nodes": self._nodes(),
            "paths": self._paths(names),
            "heats": self._heats(names),
            "heats_by_column": self._heats_by_column(names),
            "not_determined": [
                "the scale of all capacities, conductances and heats together",
                *undetermined(result.found, self.spread, [one.column for one in result.data.driving]),
            ],
        }

    def _natural(self) -> dict[str, Any] | None:
        """Natural convection's share of what surfaces lose at rest, or None where no part of it is told apart."""
        found = self.result.found
        if not found.structure.natural:
            return None
        place = found.structure.still[0]
        logit, deviation = float(found.vector[place]), float(self.spread.deviation[place])
        middle, low, high = (1.0 / (1.0 + np.exp(-(logit + by * deviation))) for by in (0.0, -INTERVAL, INTERVAL))
        return {"share_at_rest": {"value": float(middle), "interval": [float(low), float(high)]}, "at_K": USUAL_K}

    def _component(self, s: int) -> dict[str, Any]:
        result, steady = self.result, self.steady
        place = result.found.structure.offsets[s]
        speeds = {
            str(pwm): {
                "steady_rise_K": {
                    "value": float(steady.rise[k, s]),
                    "interval": _interval(float(steady.rise[k, s]), float(steady.deviation[k, s])),
                }
            }
            for k, pwm in enumerate(self.speeds)
        }
        errors = [
            {
                "pwm": list(band.pwm),
                "model_minus_measured_K": [float(band.low[s]), float(band.high[s])],
                "rms_K": float(band.rms[s]),
            }
            for band in bands(result.inputs, result.judged, result.data.full_scale)
        ]
        offset = float(result.found.vector[place])
        return {
            "rms_K": {run.name: float(self.rms_K[r, s]) for r, run in enumerate(result.data.fine)},
            "left_out_rms_K": float(self.left_out_K[s]),
            "left_out": errors,
            "sensor_offset_K": {"value": offset, "interval": _interval(offset, float(self.spread.deviation[place]))},
            "speeds": speeds,
        }

    def _nodes(self) -> list[dict[str, Any]]:
        structure, vector = self.result.found.structure, self.result.found.vector
        return [
            {
                "name": name,
                "sensed": i < len(structure.sensed),
                "capacity_J_per_K": _factor(float(vector[i]), float(self.spread.deviation[i])),
                "determined_share": float(1.0 - min(self.spread.share[i], 1.0)),
                **self._start(i),
            }
            for i, name in enumerate(structure.names)
        ]

    def _start(self, node: int) -> dict[str, Any]:
        """By how much more than it would rest at a hidden node begins; nothing where no run says."""
        found, hidden = self.result.found, node - self.result.found.structure.sensors
        if hidden < 0 or not found.structure.factors.size:
            return {}
        place = found.structure.factors[hidden]
        return {"start_factor": _factor(float(found.vector[place]), float(self.spread.deviation[place]))}

    def _paths(self, names: tuple[str, ...]) -> list[dict[str, Any]]:
        structure, vector = self.result.found.structure, self.result.found.vector
        levels = held(np.array([0.0, 127.5, 255.0]), 255)
        conductance = structure.physical(levels, vector).conductance
        made = []
        for q, (i, j) in enumerate(structure.paths):
            level = structure.conductances[q].start + structure.laws[q].level
            made.append(
                {
                    "between": [names[i], names[j]],
                    "conductance_W_per_K": dict(
                        zip(("at_rest", "at_half_speed", "at_full_speed"), conductance[:, q].tolist(), strict=True)
                    ),
                    "determined_share": float(1.0 - min(self.spread.share[level], 1.0)),
                }
            )
        return made

    def _heats(self, names: tuple[str, ...]) -> list[dict[str, Any]]:
        structure, vector = self.result.found.structure, self.result.found.vector
        heat = structure.physical(held(np.array([127.5, 255.0]), 255), vector).heat
        return [
            {"node": names[i], "power_W": {"at_half_speed": float(heat[0, i]), "at_full_speed": float(heat[1, i])}}
            for i in structure.heated
        ]

    def _heats_by_column(self, names: tuple[str, ...]) -> list[dict[str, Any]]:
        structure, vector = self.result.found.structure, self.result.found.vector
        driving = self.result.data.driving
        return [
            {
                "node": names[i],
                "column": driving[number].column,
                "power": driving[number].power,
                "at": driving[number].largest,
                "power_W": _factor(float(vector[at]), float(self.spread.deviation[at])),
            }
            for (number, i), at in zip(structure.fed, structure.feeds.tolist(), strict=True)
        ]

    def text(self) -> str:
        """What the command prints."""
        whole = self.as_json()
        structure = self.result.found.structure
        lines = [
            f"network of {structure.nodes} nodes, {structure.hidden} of them hidden, {len(structure.paths)} paths, "
            f"{len(structure.heated) + len(structure.fed)} heats{self._by_columns()}",
            f"  over speed they {BENDING if structure.bend == BEND else POWERS}",
            *(f"  {line}" for line in in_still_air(whole["natural_convection"])),
            "  hidden nodes  error on data left out (K)",
            *(f"  {c.hidden:>12}  {c.left_out_K:.2f}" for c in self.result.candidates),
            f"part        in the runs (K)  left out (K)  {steady_rise_title(self.result)}",
        ]
        for s, name in enumerate(self.result.data.names):
            own = float(np.sqrt(np.nanmean(self.rms_K[:, s] ** 2)))
            rises = ", ".join(
                f"{pwm}: {self.steady.rise[k, s]:.1f} ±{INTERVAL * self.steady.deviation[k, s]:.1f}"
                for k, pwm in enumerate(self.speeds)
            )
            lines.append(f"{name:<10}  {own:<15.2f}  {self.left_out_K[s]:<12.2f}  {rises}")
        lines += self._not_used()
        lines.append(whole["verdict"])
        lines += [f"warning: {warning}" for warning in whole["warnings"]]
        return "\n".join(lines)

    def _by_columns(self) -> str:
        """Which of the heats come by measured columns."""
        driving = self.result.data.driving
        used = dict.fromkeys(driving[number].column for number, _ in self.result.found.structure.fed)
        unused = dict.fromkeys(one.column for one in driving if one.column not in used)
        said = f", {len(self.result.found.structure.fed)} of them by {', '.join(used)}" if used else ""
        return said + (f" ({', '.join(unused)} heats nothing that is seen)" if unused else "")

    def _not_used(self) -> list[str]:
        """Columns that could heat the motor, too: every run has them, and they change."""
        sources, taken = self.result.data.sources, {one.column for one in self.result.data.driving}
        common = set.intersection(*(set(source.run.extras) for source in sources)) - taken
        moving = [
            column
            for column in sorted(common)
            if column.endswith(HEATING) and any(_moves(source.run.extras[column]) for source in sources)
        ]
        if not moving:
            return []
        return [
            f"not used: {', '.join(moving)}; what else heats the motor, and the board can measure, tell with --heat"
        ]


def _moves(values: FloatArray) -> bool:
    """Whether a column changes; one without values does not."""
    return np.unique(values[np.isfinite(values)]).size > 1


def _time(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


def _interval(value: float, sd: float) -> list[float]:
    return [value - INTERVAL * sd, value + INTERVAL * sd]


def _factor(log: float, sd: float) -> dict[str, Any]:
    bound = INTERVAL * min(sd, 5.0)
    return {"value": float(np.exp(log)), "interval": [float(np.exp(log - bound)), float(np.exp(log + bound))]}


def in_still_air(natural: Mapping[str, Any] | None) -> list[str]:
    """Say what goes by natural convection; nothing where none was found."""
    if natural is None:
        return []
    share = natural["share_at_rest"]
    low, high = share["interval"]
    return [
        f"{share['value']:.0%} ({low:.0%} to {high:.0%}) of what surfaces lose at rest goes by natural convection, "
        "which grows with their rise"
    ]
