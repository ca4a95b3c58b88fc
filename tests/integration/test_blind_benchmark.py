"""Forty withheld-effect cases of a fresh seed, diagnosed and scored: does the diagnosis still do what it does?

The seed is another one each time, so nothing can be tuned to it. A bound is wide enough that a program whose true rate
is the assumed one breaks any of them with a probability below FALSE_ALARM in a run. The full benchmark, with targets
instead of assumed rates, is ./dev study blind.
"""

import json
import math
import os
import time
import unittest

from umov_case import UmovCase

CASES = 40
FALSE_ALARM = 1e-4
# Core seconds that the median case may take.
SECONDS_A_CASE = 5.0

# What the diagnosis is taken to reach with --quick on the case's own scan alone; better rates where they are known.
AT_LEAST = {
    "top1_set": 0.70,           # single effects of rho >= 10, up to the ambiguity set
    "detection": 0.85,          # known effects of rho >= 7
    "claims_right": 0.75,       # claims on known effects that are true, up to their set
    "set_coverage": 0.70,       # single effects of any rho, where one is named
    "interval_coverage": 0.70,  # 95 % intervals of true claims
    "unknown_flagged": 0.50,    # effects that no catalogue has, of rho >= 8 and unlike any other
}
AT_MOST = {
    "false_alarms": 0.25,   # cases without an effect
    "known_flagged": 0.25,  # known effects called unknown
    "failed": 0.001,        # scans that could not be diagnosed
}


def chance_of_at_most(hits, n, rate):
    return sum(math.comb(n, k) * rate**k * (1 - rate) ** (n - k) for k in range(hits + 1))


def least_hits(n, rate, risk):
    """The least number of hits that is no surprise: fewer come with a probability below `risk`."""
    hits = 0
    while hits < n and chance_of_at_most(hits, n, rate) < risk:
        hits += 1
    return hits


def most_hits(n, rate, risk):
    return n - least_hits(n, 1 - rate, risk)


def broken_bounds(measures, at_least, at_most):
    """Sentences, one a bound that the measures of `umov blind score --json` break."""
    risk = FALSE_ALARM / (len(at_least) + len(at_most))
    broken = []
    for bounds, limit, fits, word in ((at_least, least_hits, int.__ge__, "at least"),
                                      (at_most, most_hits, int.__le__, "at most")):
        for name, rate in bounds.items():
            measure = measures[name]["diagnosis"]
            allowed = limit(measure["n"], rate, risk)
            if not fits(measure["hits"], allowed):
                broken.append(f"{name}: {measure['hits']} of {measure['n']}, {word} {allowed} were to be expected")
    return broken


class Bounds(unittest.TestCase):
    def test_a_program_as_good_as_assumed_hardly_ever_breaks_a_bound(self):
        for n in range(0, 41):
            for rate in (0.05, 0.3, 0.55, 0.9, 0.999):
                least, most = least_hits(n, rate, 1e-5), most_hits(n, rate, 1e-5)
                self.assertLess(chance_of_at_most(least - 1, n, rate) if least > 0 else 0.0, 1e-5)
                self.assertLess(1 - chance_of_at_most(most, n, rate), 1.1e-5)
                self.assertLessEqual(least, n)

    def test_a_program_that_names_nothing_or_anything_breaks_them(self):
        def score(**hits):
            return {name: {"diagnosis": {"n": n, "hits": k}} for name, (k, n) in hits.items()}

        def broken(measures):
            return broken_bounds(measures, {"claims_right": 0.55, "detection": 0.85}, {"false_alarms": 0.1, "failed": 0.001})

        good = score(claims_right=(25, 32), detection=(15, 16), false_alarms=(1, 8), failed=(0, 40))
        self.assertEqual(broken(good), [])
        silent = broken(good | score(detection=(0, 16), claims_right=(0, 0)))
        self.assertEqual(len(silent), 1)
        self.assertIn("detection: 0 of 16", silent[0])
        self.assertEqual(len(broken(good | score(claims_right=(3, 40), false_alarms=(8, 8)))), 2)
        self.assertIn("failed: 3 of 40, at most", broken(good | score(failed=(3, 40)))[0])


class FreshCases(UmovCase):
    def test_effects_are_named_as_well_as_assumed_on_cases_never_seen_before(self):
        seed = int(os.environ.get("UMOV_BLIND_SEED", time.time_ns() % 2**31))
        again = f"UMOV_BLIND_SEED={seed} repeats it"
        print(f"\n{CASES} withheld-effect cases of seed {seed}; {again}", flush=True)
        self.must("blind", "make", "cases", "--truth", "sealed", "--cases", CASES, "--seed", seed, timeout=200)
        self.must("blind", "run", "cases", "--quick", "--without-floors", "--quiet", timeout=600)
        score = json.loads(self.must("blind", "score", "cases", "--truth", "sealed", "--json").stdout)
        self.assertEqual(score["answered"], CASES)
        for name, measure in score["measures"].items():
            if name in AT_LEAST or name in AT_MOST:
                print(f"  {name}: {measure['diagnosis']['hits']} of {measure['diagnosis']['n']}")
        print(f"  median {score['time']['diagnosis']['median_s']:.1f} s of one core a case, "
              f"longest {score['time']['diagnosis']['most_s']:.1f} s", flush=True)
        self.assertEqual(broken_bounds(score["measures"], AT_LEAST, AT_MOST), [], again)
        self.assertLessEqual(score["time"]["diagnosis"]["median_s"], SECONDS_A_CASE, again)
        # The same answers know nothing of other cases.
        right, shuffled = (score["measures"]["claims_right"][of]["value"] for of in ("diagnosis", "permuted"))
        self.assertGreater(right, shuffled, again)


if __name__ == "__main__":
    unittest.main()
