"""The theorem, component by component: every claim of a certificate follows from the C++ beside it, or is refuted.

With z the exact state, y the state that the board's words stand for and e = y - z, it is shown at every |PWM| that

    c_j . (z - centre) <= reach_j   and   c_j . e <= error_j   for all j

hold after a sample if they held before it, and that they hold at every start. The words' ranges and the error of what
is read follow. docs/proof.md has the lemmas by their numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.affine import Reach, outward
from gen.certificate.disturbance import along_directions, linear_part
from gen.certificate.document import LOW_BITS, AnyCertificate, Certificate, Part
from gen.certificate.equation import Enclosure, enclose
from gen.certificate.exact import BITS, ROUGHLY, Ratio, Ratios, floats, inverse, ratios, zeros
from gen.certificate.measured import Measured, measure
from gen.certificate.network.check import prove
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.order import check_order
from gen.certificate.polytope import Directions, Images, largest, largest_roughly
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project
from gen.certificate.step import Recursion, Run
from gen.certificate.verdict import Verdict


def check(folder: Path, certificate: AnyCertificate, tell: Callable[[str], None] = lambda _: None) -> list[Verdict]:
    """Prove every claim of an emitted project.

    Parameters
    ----------
    folder
        What ``gen build`` wrote.
    certificate
        Its own.
    tell
        Gets the name of each component before it is worked on.

    Returns
    -------
    list of Verdict
        What was proven of each component that has a claim.

    Raises
    ------
    InputError
        If a file is missing, or a tool.
    Refuted
        If a claim does not follow.
    """
    if isinstance(certificate, NetworkCertificate):
        return prove(folder, certificate, tell)
    project = Project(folder, certificate.model)
    check_order(project, certificate)
    measured = measure(project, certificate)
    verdicts = []
    for part in certificate.parts:
        tell(part.name)
        try:
            with np.errstate(
                over="ignore", invalid="ignore"
            ):  # nothing compares with what comes of it, so it is refuted
                verdicts.append(PartProof(project, certificate, part, measured[part.name]).verdict())
        except Refuted as refuted:
            raise Refuted(f"{part.name}: {refuted}") from refuted
    return verdicts


class _Reach:
    """Lemma 3: what a linear function of W, the old q and the ambient's word ranges over, ``|q| <= q``."""

    def __init__(
        self,
        directions: Directions,
        heights: Ratios,
        to_words: Ratios,
        word: Ratios,
        centre: Ratio,
        q: Ratio,
        ambient: tuple[int, int],
    ) -> None:
        self._directions, self._heights = directions, heights
        self._to_words: Ratios = to_words / word[:, None]
        self._centre, self._q = centre, q
        self._ambient, self._around = Ratio(sum(ambient), 2), Ratio(ambient[1] - ambient[0], 2)

    def enclose(self, linear: Ratios) -> tuple[Ratios, Ratios]:
        """See :class:`gen.certificate.affine.Reach`."""
        towards = linear[:-2].T @ self._to_words  # of y, shape (P, n)
        half = zeros(len(towards))
        moved = np.array([bool(row.any()) for row in towards])
        if moved.any():
            half[moved] = np.frompyfunc(outward, 1, 1)(largest(self._directions, self._heights, towards[moved]))
        middle = towards[:, 0] * self._centre + linear[-1] * self._ambient
        return middle, half + np.abs(linear[-2]) * self._q + np.abs(linear[-1]) * self._around

    def roughly(self, linear: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See :class:`gen.certificate.affine.Reach`."""
        words = floats(self._to_words)
        towards = linear[:-2].T @ words
        lost = (
            ROUGHLY
            * (np.abs(linear[:-2]).T @ np.abs(words))
            @ (floats(self._directions.box(self._heights)) + np.eye(words.shape[1])[0] * abs(float(self._centre)))
        )
        half = largest_roughly(self._directions, self._heights, towards)
        beside = np.abs(linear[-2]) * float(self._q) + np.abs(linear[-1]) * float(self._around)
        lost += ROUGHLY * np.abs(linear[-1]) * abs(float(self._ambient))
        middle = towards[:, 0] * float(self._centre) + linear[-1] * float(self._ambient)
        return middle, half + lost + beside * (1.0 + ROUGHLY)


class PartProof:
    """One component's proof.

    Parameters
    ----------
    project, certificate, part, measured
        The component, and what running its C++ gave.

    Raises
    ------
    Refuted
        If the certificate does not fit together.
    """

    def __init__(self, project: Project, certificate: Certificate, part: Part, measured: Measured) -> None:
        self._part, self._measured = part, measured
        self._directions = Directions(ratios(part.directions), floats(ratios(part.shape_matrix)))
        self._reach, self._error = ratios(part.reach), ratios(part.error)
        self._both = self._reach + self._error
        self._exact: Enclosure = enclose(
            part.equation, certificate.domain_pwm, certificate.sample_time_s / part.substeps
        )
        self._map = ratios(part.map)
        if self._map[0, 0] != 1 or self._map[1:, 0].any():
            raise Refuted("the map moves a state at rest")
        try:
            self._back = inverse(self._map)
        except ZeroDivisionError as error:
            raise Refuted("the map has no inverse") from error
        self._unit = Ratio(1, 1 << part.fraction_bits[0])  # of what is read
        low_bits = LOW_BITS[certificate.arithmetic]
        self._word = ratios(Ratio(1, 1 << bits + low_bits) for bits in part.fraction_bits)
        over = certificate.ambient.over_mK if certificate.ambient is not None else (0, 0)
        self._over = ratios(Ratio(end, 1000) for end in over)  # of the ambient, in K
        self._away = np.abs(self._exact.steady[:, None] + self._over[None, :] - part.centre).max(axis=1)
        self.recursion = Recursion(
            project, certificate.arithmetic, part, measured.table, ambient=certificate.ambient is not None
        )

    def verdict(self) -> Verdict:
        """Prove everything; see :mod:`gen.certificate.check`.

        Raises
        ------
        Refuted
            At the first step that fails.
        """
        runs, q = self.recursion.runs(self.enclosing)
        self._check_starts()
        count = self._check_steps(runs)
        bound = self._bound(q)
        if bound > self._part.bound_K:
            raise Refuted(f"the error may reach {float(bound):.6g} K, claimed are {float(self._part.bound_K):.6g} K")
        if bound + self._measured.reading_K > self._part.reading_K:
            raise Refuted(
                f"what rise_mK gives may be off by {float(bound + self._measured.reading_K):.6g} K, claimed are "
                f"{float(self._part.reading_K):.6g} K"
            )
        return Verdict(self._part.name, self._part.bound_K, self._part.reading_K, bound, count)

    def enclosing(self, q: Ratio) -> Reach:
        """What the state ranges over, the old q being at most ``q``."""
        return _Reach(self._directions, self._both, self._map, self._word, self._part.centre, q, self._measured.ambient)

    def _check_starts(self) -> None:
        """Lemma 4: at rest at any rise of the range both polytopes hold the state."""
        part = self._part
        along = np.abs(ratios(row[0] for row in part.directions))
        low, high = (Ratio(end, 1000) for end in part.start_mK)
        away = max(high - part.centre, part.centre - low)
        if np.any(along * away > self._reach):
            raise Refuted("a start lies outside of the states' polytope")
        if np.any(along * self._measured.start_K > self._error):
            raise Refuted(
                f"a start is off by {float(self._measured.start_K):.6g} K, more than the errors' polytope holds"
            )

    def _check_steps(self, runs: Sequence[Run]) -> int:
        """Lemmas 5 and 6: both polytopes hold the state after a sample; the number of inequalities."""
        exact, along = self._exact, self._directions.nearest
        images = Images(self._directions, floats(exact.transition) * 2.0**-BITS)
        away = self._away
        # What the enclosure of E and S leaves open: |c| (E's radius (|u| + |e| + |S - centre|) + S's (1 + |E|)).
        radius = exact.radius * Ratio(1, 1 << BITS)
        size = np.abs(exact.transition).sum(axis=(1, 2)) * Ratio(1, 1 << BITS)
        open_K = radius * (self._directions.box(self._both).sum() + away) + exact.steady_radius * (2 + size)
        slack = np.abs(along).sum(axis=1)[None, :] * floats(open_K)[:, None] * (1.0 + ROUGHLY)
        identity = np.eye(self._part.order, dtype=object) * (1 << BITS)
        towards = floats((identity - exact.transition)[:, :, 0] * Ratio(1, 1 << BITS) * away[:, None])
        driven = np.abs(towards @ along.T) + ROUGHLY * (np.abs(towards) @ np.abs(along).T)
        self._decide(images, self._reach, driven + slack, "states'", "")
        held: tuple[Ratios, FloatArray] | None = None
        for run in runs:
            differs, constant = self._beside_exact(run)
            linear, when = self._linear(differs), ""
            if held is not None:  # after a change: what it does beside the run with PWM held may be told apart
                linear = np.minimum(linear, held[1] + self._linear(differs - held[0]))
                when = " just after a change"
            held = held or (differs, linear)
            added = linear + self._rounding(run, constant, self._ambient(run)) + slack
            self._decide(images, self._error, added, "errors'", when)
        return int(driven.size) * (1 + len(runs))

    def _decide(self, images: Images, heights: Ratios, added: FloatArray, whose: str, when: str) -> None:
        """Whether a polytope holds all that comes of it, (*) of :mod:`gen.certificate.check`."""
        box = floats(self._directions.box(heights)) * (1.0 + ROUGHLY)
        needed = (images.largest(floats(heights), box) + added) * (1.0 + ROUGHLY)
        if not np.all(needed <= floats(heights)):
            row = int(np.argmax((needed - floats(heights)).max(axis=1)))
            raise Refuted(f"the {whose} polytope is left at |PWM| {self._measured.first_pwm + row}{when}")

    def _beside_exact(self, run: Run) -> tuple[Ratios, Ratios]:
        """D and d with e -> E e + D (y - s) + d + columns t, shapes (P, n, n) and (P, n)."""
        exact, to_y, from_y = self._exact, self._back * self._word[None, :], self._map / self._word[:, None]
        matrix = np.array([to_y @ one @ from_y for one in run.matrix])  # y -> matrix y + constant
        constant = np.array([to_y @ one for one in run.constant])
        first = np.zeros(self._part.order, dtype=object)
        first[0] = 1
        at_rest = matrix[:, :, 0] * exact.steady[:, None] + constant - first[None, :] * exact.steady[:, None]
        return matrix - exact.transition * Ratio(1, 1 << BITS), at_rest

    def _linear(self, differs: Ratios) -> FloatArray:
        own_q = (self.recursion.drive.linear / self._word[:, None]).T @ self._map
        return linear_part(self._directions, self._both, differs, self._away, own_q)

    def _ambient(self, run: Run) -> Ratios:
        """What the ambient adds to e beside what it should, as columns, shape (P, 2, n).

        It should move a rest at T to one at T + a; and its word is not quite a.
        """
        to_y, from_y = self._back * self._word[None, :], self._map / self._word[:, None]
        first = np.array([to_y @ one @ from_y[:, 0] for one in run.matrix])
        drive = np.array([to_y @ one for one in run.ambient]) / self._unit  # for a kelvin of the ambient's word
        first[:, 0] -= 1
        moved = (first + drive) * np.abs(self._over).max()
        found: Ratios = np.stack([moved, drive * self._measured.ambient_K], axis=1)
        return found

    def _rounding(self, run: Run, constant: Ratios, ambient: Ratios) -> FloatArray:
        """What roundings add to each ``c_j . e``, shape (P, J)."""
        back = floats(self._back * self._word[None, :]).T
        beside = floats(constant[:, None, :])
        beside = np.concatenate([beside, floats(ambient)], axis=1)
        columns = np.concatenate([run.columns @ back, beside], axis=1)
        sizes = np.concatenate([np.abs(run.columns) @ np.abs(back), np.abs(beside)], axis=1)
        return along_directions(self._directions, columns, sizes)

    def _bound(self, q: Ratio) -> Ratio:
        """Lemma 7: what is read is x1's upper bits, rounded down."""
        n = self._part.order
        first = zeros(1, n)
        first[0, 0] = Ratio(1)
        bound = largest(self._directions, self._error, first)[0]
        beside = self._map[:1].copy()
        beside[0, 0] = Ratio(0)
        if beside.any():
            bound += largest(self._directions, self._both, beside)[0]
        if n == 2:
            bound += abs(self.recursion.drive.share) * q * self._word[0]
        return Ratio(bound + self._unit)
