"""What there is to say of an identified network: how good it is, for what, and what to beware of."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.provenance import ErrorBand
from gen.identification.grades import FAIR_K, GOOD_K, NOISES, Grade, Miss, told, worse_than
from gen.identification.network.identify import NetworkFound
from gen.identification.network.left_out import FEW, each_alone
from gen.identification.network.telling.coarse import coarse
from gen.identification.network.telling.declared import error_bands
from gen.identification.network.telling.document import measured_range, rest_was_measured, turned_range
from gen.identification.network.telling.held import only_speeds
from gen.identification.network.telling.resting import REST_S, rested
from gen.identification.network.telling.uncertainty import Spread, Steady, spread_of, steady_of
from gen.identification.network.used import rms_K

SETTLED = 3.0
"""Time constants that a hold has to last for its part to have settled (95 %)."""
INTERVAL = 1.96
OFFSET_SURE = 3.0
OTHERWISE = 2.0
"""Times the error from starts of its own: a run that the file misses by more begins otherwise than the file says."""
MOST_SPEEDS = 12


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
        total = np.bincount(pwm, np.where(inputs.levels.turns, time, 0.0))
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

    @cached_property
    def later_K(self) -> FloatArray | None:
        """What the second half of the only run is missed by from a fit to its first, by part, shape (S,), K."""
        later = self.result.later
        return None if later is None else np.asarray(np.sqrt(later.by_fold[0]))

    @cached_property
    def declared(self) -> ErrorBand:
        """Where the file declares most."""
        bands = error_bands(self.result, self.spread, turned_range(self.result))
        return max(bands, key=lambda band: max(map(abs, band.model_minus_measured_K)))

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
        return None if worse_than(Grade.GOOD, self.left_out) else float(np.nanmax(self.left_out_K))

    @property
    def verdict(self) -> str:
        """Whether the model is good to be built, in one line; the rule is `grades`'."""
        bad, fair = (worse_than(grade, self.left_out) for grade in (Grade.FAIR, Grade.GOOD))
        if bad:
            return f"Not good yet: {self._on(bad)} it misses {told(bad)}."
        only, worst = self._only(), float(np.nanmax(self.left_out_K))
        # What is left out there is a whole speed, which tells of what lies between speeds and not of these.
        if fair and each_alone(self.result.inputs) and not worse_than(Grade.GOOD, self.own):
            return f"Good at the measured speeds{only}. Speeds that were left out it misses: {told(fair)}."
        if fair:
            on = self._on(fair)
            return f"Fair{only}{f'. {_begun(on)}' if only else f': {on}'} it misses {told(fair)}."
        if only:
            return f"Good{only}. {_begun(self._data)} are predicted to {worst:.2g} K{self._later()}."
        return (
            f"Good: {'stretches' if self.few else 'runs'} that took no part in the fit are predicted, at rest and at "
            f"the measured speeds, to {worst:.2g} K (root mean square of the worst part){self._later()}."
        )

    def _later(self) -> str:
        """What is foretold of the only run, beside stretches that lie between what the fit knows."""
        later = self.later_K
        if later is None or not np.isfinite(later).any():
            return ""
        return f", the second half of the run from its first alone to {float(np.nanmax(later)):.2g} K"

    @property
    def few(self) -> bool:
        """Whether there are so few runs that what was left out are stretches of them."""
        return len(self.result.inputs.runs) <= FEW

    @property
    def _data(self) -> str:
        return f"{'stretches of the same runs' if self.few else 'data'} that took no part in the fit"

    def _on(self, misses: Sequence[Miss]) -> str:
        """Where parts are missed by that: on what was left out, or in the runs themselves, as the file follows them."""
        left_out = dict(zip(self.result.data.names, self.left_out_K.tolist(), strict=True))
        if all(miss.error_K <= left_out[miss.name] for miss in misses):
            return f"on {self._data}"
        return "in the runs themselves, with the starts and the room that the file has for them,"

    def _only(self) -> str:
        """What it is good for alone, or nothing."""
        longest, slowest = self.span_s
        at = f" at {self._held()}" if self.only_speeds else ""
        if longest < SETTLED * slowest:
            return f"{at} for changes over up to {_time(longest)}; where the parts would settle is extrapolated"
        if not rest_was_measured(self.result):
            return f"{at} while the motor turns; cooling at rest was not measured"
        return f"{at} alone" if at else ""

    @cached_property
    def only_speeds(self) -> list[int]:
        """The |PWM| at which a motor was held for most of the time, where these are one or two; none of a heater."""
        data = self.result.data
        return [] if data.driven else only_speeds(self.result.inputs, data.full_scale)

    def _held(self) -> str:
        return f"PWM {' and '.join(map(str, self.only_speeds))}"

    def warnings(self) -> list[str]:
        """What to look at, one sentence each."""
        result = self.result
        said = list(result.data.warnings)
        said += [
            f"{miss.name}: {self._on([miss])} the network misses it by {miss.sized}, root mean square"
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
        if self.only_speeds:
            said.append(
                f"most of the time that the motor turned it was held at {self._held()}: how it warms at other speeds "
                "is taken from what is usual of motors, which a propeller or a load is not; runs at others would show "
                "it"
            )
        if not rest_was_measured(result):
            said.append(self._rest())
        if len(result.inputs.runs) == 1:
            said.append(
                "all of it is one run: what was left out are stretches of it, which say nothing of another room, start "
                "or day; a second run, of another profile, would"
            )
        said += self._declared()
        said += self._starts()
        said += self._room()
        for s, name in enumerate(result.data.names):
            offset = float(result.found.vector[result.found.structure.offsets[s]])
            sd = float(self.spread.deviation[result.found.structure.offsets[s]])
            if abs(offset) > OFFSET_SURE * sd:
                said.append(f"{name}: its sensor reads {offset:+.2f} K against the ambient's (±{INTERVAL * sd:.2f} K)")
        return said

    def _declared(self) -> list[str]:
        """An error that the file declares and that no model would be called fair with."""
        band = self.declared
        most = max(map(abs, band.model_minus_measured_K))
        if most <= FAIR_K:
            return []
        low, high = band.pwm
        at = f"PWM {low}" if low == high else f"PWM {low} to {high}"
        return [
            f"the file declares errors of up to {most:.0f} K ({band.component}, {at}): so much the runs leave open on "
            "other profiles, and no rule of alarms that counts from it hears less"
        ]

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
        if data.ambient_fixed is None:
            return [
                f"the room was noted, not measured, in {len(unknown)} run(s): what they show beside it (up to "
                f"{most:.1f} K) is no part of the model; a room that moves moves the parts"
            ]
        return [
            f"the room was not measured in {len(unknown)} run(s): {data.ambient_fixed:.1f} degC is taken, and what the "
            f"runs show beside it (up to {most:.1f} K) is no part of the model; a room that moves moves the parts"
        ]


def _begun(sentence: str) -> str:
    return sentence[0].upper() + sentence[1:]


def _time(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
