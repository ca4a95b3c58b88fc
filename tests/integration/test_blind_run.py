"""Runs over withheld-effect cases: resumed, shared between processes, independent of both; the score of any answers."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from umov_case import SOURCE, UMOV, UmovCase

SMALL = SOURCE / "tests/data/foreign_scans/scan_07_part.csv"


class BlindRun(UmovCase):
    def small_set(self, count):
        """A set of another maker: small scans, no seal. They differ in gain, so that no answer is another's."""
        lines = SMALL.read_text().splitlines()
        head = next(i for i, line in enumerate(lines) if not line.startswith("#"))
        for number in range(1, count + 1):
            folder = self.folder / f"set/case_{number:04}"
            folder.mkdir(parents=True)
            kept = lines[:head] + [f"# note: copy {number}"] + lines[head:]
            (folder / "scan.csv").write_text("\n".join(kept) + "\n")

    def answers(self, folder="set"):
        return {path.relative_to(self.folder / folder).as_posix(): path.read_bytes()
                for path in sorted((self.folder / folder).rglob("*.json"))
                if path.name in ("answer.json", "rivals.json")}

    def mpirun(self, ranks, *arguments):
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", ranks, UMOV, *arguments]
        return subprocess.run(list(map(str, command)), cwd=self.folder, env=environment, text=True, capture_output=True,
                              timeout=120, check=False)

    def started_until_the_first_answer(self):
        process = self.start("blind", "run", "set", "--quick", "--threads", 1, "--quiet")
        deadline = time.monotonic() + 60
        # A case's answer is written last of its files.
        while not any(name.endswith("/answer.json") for name in self.answers()) and time.monotonic() < deadline:
            time.sleep(0.02)
        return process

    def test_a_killed_run_goes_on_where_it_was_and_its_claims_come_free(self):
        self.small_set(4)
        process = self.started_until_the_first_answer()
        process.send_signal(signal.SIGKILL)
        process.wait()
        before = {name: (self.folder / "set" / name).stat().st_mtime_ns for name in self.answers()}
        answered = [name for name in before if name.endswith("answer.json")]
        self.assertGreaterEqual(len(answered), 1)
        self.assertLess(len(answered), 4)
        said = json.loads(self.must("blind", "run", "set", "--quick", "--json").stdout)
        # The case under way may have been answered between the two looks; none is answered twice.
        self.assertIn(4 - len(answered) - said["answered_here"], (0, 1))
        self.assertEqual(len([name for name in self.answers() if name.endswith("answer.json")]), 4)
        for name in answered:
            self.assertEqual((self.folder / "set" / name).stat().st_mtime_ns, before[name])
        again = json.loads(self.must("blind", "run", "set", "--quick", "--json").stdout)
        self.assertEqual(again["answered_here"], 0)

    def test_an_interrupted_run_ends_cleanly_and_says_how_to_go_on(self):
        self.small_set(6)
        process = self.started_until_the_first_answer()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("goes on", errors)
        for name, text in self.answers().items():
            json.loads(text)
            self.assertIn("case_", name)

    def test_answers_do_not_depend_on_threads_or_ranks(self):
        self.small_set(3)
        self.must("blind", "run", "set", "--quick", "--answers", "one", "--threads", 1)
        self.must("blind", "run", "set", "--quick", "--answers", "two", "--threads", 2)
        self.assertEqual(len(self.answers("one")), 6)
        self.assertEqual(self.answers("one"), self.answers("two"))
        if not shutil.which("mpirun"):
            self.skipTest("there is no mpirun: ranks were not compared")
        done = self.mpirun(2, "blind", "run", "set", "--quick", "--answers", "ranks", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        said = json.loads(done.stdout)
        self.assertEqual(said["ranks"], 2)
        self.assertLess(said["answered_here"], 3)
        self.assertEqual(self.answers("one"), self.answers("ranks"))

    def test_answers_of_other_options_are_not_mixed_in(self):
        self.small_set(1)
        self.must("blind", "run", "set", "--quick", "--without-floors")
        self.refused("blind", "run", "set", "--quick", "--seed", 2, "--without-floors", says=["RUN.json", "other options"])
        record = json.loads((self.folder / "set/RUN.json").read_text())
        record["program"]["sha256"] = "0" * 64
        (self.folder / "set/RUN.json").write_text(json.dumps(record))
        self.refused("blind", "run", "set", "--quick", "--without-floors", says=["RUN.json", "another build"])
        (self.folder / "set/RUN.json").unlink()
        self.refused("blind", "run", "set", "--quick", "--without-floors", says=["unknown program"])

    def test_a_scan_that_cannot_be_diagnosed_is_answered_as_failed(self):
        (self.folder / "set/case_0001").mkdir(parents=True)
        (self.folder / "set/case_0001/scan.csv").write_text("\n".join(SMALL.read_text().splitlines()[:40]) + "\n")
        self.must("blind", "run", "set", "--quick")
        answer = json.loads((self.folder / "set/case_0001/answer.json").read_text())
        self.assertEqual(answer["verdict"], "failed")
        self.assertTrue(answer["error"])
        self.assertEqual(answer["causes"], [])

    def test_a_case_that_brings_the_diagnosis_down_does_not_stop_the_others(self):
        self.small_set(2)
        process = self.start("blind", "run", "set", "--quick", "--threads", 1, "--quiet")
        children = pathlib.Path(f"/proc/{process.pid}/task")
        victim, deadline = None, time.monotonic() + 30
        while not victim and time.monotonic() < deadline:
            victim = next((int(pid) for task in children.glob("*/children") for pid in task.read_text().split()), None)
        os.kill(victim, signal.SIGSEGV)
        process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0)
        answers = [json.loads((self.folder / f"set/case_000{i}/answer.json").read_text()) for i in (1, 2)]
        self.assertEqual(answers[0]["verdict"], "failed")
        self.assertIn("Segmentation", answers[0]["error"])
        self.assertNotEqual(answers[1]["verdict"], "failed")

    def test_what_cannot_be_run_is_refused(self):
        self.refused("blind", "run", "nowhere", says=["nowhere"])
        (self.folder / "empty").mkdir()
        self.refused("blind", "run", "empty", says=["scan.csv"])
        self.small_set(1)
        self.refused("blind", "run", "set", "--leave-out", says=["--leave-out", "--truth"])
        self.refused("blind", "run", "set", "--truth", "nowhere", says=["truth.json"])
        self.refused("blind", "run", "set", "--without", "ghosts", "--answers", "a", says=["ghosts"])


class BlindScore(UmovCase):
    def setUp(self):
        super().setUp()
        self.must("blind", "make", "cases", "--truth", "sealed", "--cases", 4, "--seed", 12, "--effect", "backlash",
                  "--rho-min", 12, "--style", "serpentine", "--quiet")

    def answer(self, number, verdict, *causes, name="answer.json"):
        truth = json.loads((self.folder / "sealed/truth.json").read_text())["cases"][number - 1]
        gap = truth["effects"][0]["parameters"]["gap_deg"]
        listed = [{"effect": effect, "probability": 0.9, "share": 1.0 / (i + 1),
                   "parameters": {"gap_deg": {"value": gap, "lo": 0.9 * gap, "hi": 1.1 * gap}}}
                  for i, effect in enumerate(causes)]
        path = self.folder / f"cases/case_{number:04}/{name}"
        path.write_text(json.dumps({"verdict": verdict, "causes": listed, "ambiguity_sets": []}))

    def test_answers_of_any_program_are_scored(self):
        self.answer(1, "explained", "backlash")
        self.answer(2, "explained", "detector_zero")
        self.answer(2, "explained", "backlash", name="answer_followed.json")
        self.answer(3, "unexplained")
        score = json.loads(self.must("blind", "score", "cases", "--truth", "sealed", "--json").stdout)
        self.assertEqual((score["cases"], score["answered"]), (4, 3))
        measures = {name: m["diagnosis"] for name, m in score["measures"].items()}
        self.assertEqual((measures["top1_set"]["hits"], measures["top1_set"]["n"]), (1, 3))
        self.assertEqual(measures["top1_followed"]["hits"], 2)
        self.assertEqual(measures["detection"]["hits"], 3)
        self.assertEqual(measures["known_flagged"]["hits"], 1)
        self.assertEqual((measures["interval_coverage"]["hits"], measures["interval_coverage"]["n"]), (1, 1))
        self.assertEqual(score["by_effect"]["backlash"]["plain"], {"hits": 1, "n": 3})
        self.must("blind", "score", "cases", "--truth", "sealed", "-o", "score.md", "--quiet")
        page = (self.folder / "score.md").read_text()
        self.assertIn("3 of 4 cases answered", page)
        self.assertIn("| case_0002 | single | top1_set |", page)

    def test_a_truth_that_was_touched_is_void(self):
        self.answer(1, "explained", "backlash")
        with (self.folder / "sealed/truth.json").open("a") as file:
            file.write("\n")
        self.refused("blind", "score", "cases", "--truth", "sealed", says=["sealed with"])

    def test_what_is_no_answer_is_refused(self):
        self.refused("blind", "score", "cases", "--truth", "sealed", says=["answer.json"])
        (self.folder / "cases/case_0001/answer.json").write_text("{}")
        self.refused("blind", "score", "cases", "--truth", "sealed", says=["case_0001/answer.json", "verdict"])


if __name__ == "__main__":
    unittest.main()
