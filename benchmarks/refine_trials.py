"""Planted effects: does `gen refine` find what was planted, and only that?

    python benchmarks/refine_trials.py --share 1.0 --seed 50000 --out trials.jsonl
    python benchmarks/refine_trials.py --share 1.0 --seed 50000 --wide --out wide.jsonl

``--share 1.0``: every library effect alone x 20, nothing x 50, pairs x 50, eight effects outside the library x 10.
``--wide`` plants the same effects in forms that the library does not have. Prints the confusion matrix, errors on test
runs before and after beside the noise floor, and the goals beside what was reached. Every result is appended to the
file at once; an interrupted campaign goes on where it stopped when the command is given again. ``--part 0/2`` does
every second trial, so that two processes share the work; ``--table A.jsonl B.jsonl`` prints their table. The noise
floor is the RMSE of the readings about the truth, the sensors' small constant offsets included.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from gen.coefficients import load  # noqa: E402
from gen.refinement.parts.refine import refine  # noqa: E402
from tests.refinement.plant import COEFFICIENTS  # noqa: E402
from tests.refinement.plant_effects import LIBRARY, OUTSIDE, make  # noqa: E402


def trial(kinds: tuple[str, ...], seed: int, wide: bool) -> dict[str, Any]:
    """Plant, refine, compare."""
    folder = Path(tempfile.mkdtemp(prefix="refine-trial-"))
    try:
        fit, test, floor = make(folder, kinds, seed, wide=wide)
        started = time.perf_counter()
        found = refine(load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8"), fit, test)
        seconds = time.perf_counter() - started
    finally:
        shutil.rmtree(folder)
    effects = [e for e in found.effects if not e["evidence"].get("within_tolerance")]
    return {
        "planted": list(kinds),
        "seed": seed,
        "wide": wide,
        "verdict": found.verdict,
        "named": list(dict.fromkeys(e["name"] for e in effects)),
        "lookalikes": sorted({o["name"] for e in effects for o in e["evidence"]["lookalikes"]}),
        "confident": any(e["evidence"]["confident"] for e in effects),
        "components": [e["component"] for e in effects],
        "before_K": found.before.summary()["test"]["rmse_K"],
        "after_K": found.after.summary()["test"]["rmse_K"],
        "floor_K": floor,
        "seconds": seconds,
    }


def campaign(share: float) -> list[tuple[tuple[str, ...], int]]:
    """The trials, in an order in which any beginning of the list is a fair sample."""

    def count(full: int) -> int:
        return max(1, round(full * share))

    made: list[tuple[tuple[str, ...], int]] = []
    for seed in range(count(20)):
        made += [((name,), seed) for name in LIBRARY]
    made += [((), seed) for seed in range(count(50))]
    random = np.random.default_rng(7)
    for seed in range(50):
        pair = tuple(str(name) for name in random.choice(LIBRARY, 2, replace=False))
        if seed < count(50):
            made.append((pair, 1000 + seed))
    for seed in range(count(10)):
        made += [((name,), 2000 + seed) for name in OUTSIDE]
    return made


def group(kinds: tuple[str, ...]) -> str:
    """Which part of the campaign a trial belongs to."""
    if len(kinds) == 1:
        return "outside" if kinds[0] in OUTSIDE else "single"
    return "pair" if kinds else "nothing"


def table(results: list[dict[str, Any]]) -> str:
    """The confusion matrix and the goals, as text."""
    lines = ["planted -> named first (count)"]
    singles = [r for r in results if len(r["planted"]) == 1 and r["planted"][0] in LIBRARY]
    for name in LIBRARY:
        own = [r for r in singles if r["planted"] == [name]]
        named = Counter(r["named"][0] if r["named"] else "-" for r in own)
        ratio = [r["after_K"] / r["floor_K"] for r in own]
        before = [r["before_K"] / r["floor_K"] for r in own]
        if own:
            cells = ", ".join(f"{key} {value}" for key, value in named.most_common())
            lines.append(
                f"  {name:27s} {cells:60s} before {np.median(before):5.1f}  after {np.median(ratio):4.2f} "
                f"(worst {max(ratio):4.2f}) x floor"
            )
    nothing = [r for r in results if not r["planted"]]
    pairs = [r for r in results if len(r["planted"]) == 2]
    out = [r for r in results if len(r["planted"]) == 1 and r["planted"][0] in OUTSIDE]
    for name in OUTSIDE:
        own = [r for r in out if r["planted"] == [name]]
        if own:
            verdicts = ", ".join(f"{k} {v}" for k, v in Counter(r["verdict"] for r in own).most_common())
            named = Counter(r["named"][0] if r["named"] else "-" for r in own)
            worst = max(r["after_K"] / max(r["before_K"], 1e-9) for r in own)
            cells = ", ".join(f"{key} {value}" for key, value in named.most_common())
            lines.append(f"  outside: {name:18s} {verdicts:48s} named {cells:50s} after/before worst {worst:.2f}")

    def share(good: list[bool]) -> str:
        return f"{np.mean(good):6.1%} of {len(good)}" if good else "   none"

    lines += ["", "goal                                                          reached"]
    first = [r["named"][:1] == r["planted"] for r in singles]
    both = [set(r["planted"]) <= set(r["named"]) for r in pairs]
    near = [r["after_K"] <= 1.2 * r["floor_K"] for r in singles]
    lines += [
        f"right name first in 90 %                                    {share(first)}",
        f"false effects on nothing at most 5 %                        {share([bool(r['named']) for r in nothing])}",
        f"pairs: both names in 80 %                                   {share(both)}",
        f"library, after-error at most 1.2 x floor                    {share(near)}",
    ]
    wrong = [r["verdict"] == "explained" and r["after_K"] > 1.5 * r["floor_K"] for r in out]
    worse = [r["after_K"] > 1.05 * r["before_K"] for r in results]
    lines += [
        f'outside, "explained" over 1.5 x floor: never                {share(wrong)}',
        f"outside, a confident name: never                            {share([r['confident'] for r in out])}",
        f"after-error over 1.05 x before-error: never                 {share(worse)}",
        f"seconds per trial (median, worst): {np.median([r['seconds'] for r in results]):.1f}, "
        f"{max(r['seconds'] for r in results):.1f}",
    ]
    return "\n".join(lines)


def done_before(path: Path | None) -> list[dict[str, Any]]:
    """Results of an earlier, perhaps interrupted, campaign: a JSON object a line; a torn last line does not count."""
    made = []
    for line in path.read_text(encoding="utf-8").splitlines() if path and path.exists() else []:
        with contextlib.suppress(json.JSONDecodeError):
            made.append(json.loads(line))
    return made


def main() -> None:
    """Run the campaign, or print the table of earlier ones."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--part", default="0/1")
    parser.add_argument("--wide", action="store_true", help="plant forms that the library does not have")
    parser.add_argument("--only", choices=["single", "nothing", "pair", "outside"])
    parser.add_argument("--seed", type=int, default=0, help="added to every trial's seed")
    parser.add_argument("--out", type=Path, help="append each result here, and skip those that it has")
    parser.add_argument("--table", type=Path, nargs="+", help="only print the table of these files")
    options = parser.parse_args()
    if options.table:
        print(table([result for path in options.table for result in done_before(path)]))
        return
    part, parts = (int(x) for x in options.part.split("/"))
    results = done_before(options.out)
    done = {(tuple(r["planted"]), r["seed"], r["wide"]) for r in results}
    wanted = [(k, s + options.seed) for k, s in campaign(options.share) if options.only in (None, group(k))]
    for kinds, seed in wanted[part::parts]:
        if (kinds, seed, options.wide) in done:
            continue
        results.append(trial(kinds, seed, options.wide))
        line = json.dumps(results[-1])
        print(line, flush=True)
        if options.out:
            with options.out.open("a", encoding="utf-8") as stream:
                stream.write(line + "\n")
    print(table(results))


if __name__ == "__main__":
    main()
