"""The page of umov diagnose, in a real browser."""

import json
import unittest

from chromium import Browser, find_chromium
from report_browser import check
from umov_case import SOURCE, UmovCase

SCANS = SOURCE / "tests/data/foreign_scans"


class DiagnosisReport(UmovCase):
    def page(self, scan, *arguments):
        self.must("diagnose", scan, "--report", "page.html", "--quiet", *arguments, timeout=300)
        page = self.folder / "page.html"
        self.assertLess(page.stat().st_size, 8e6)
        return page

    def opened(self, page, width, scheme):
        browser = Browser(find_chromium())
        self.addCleanup(browser.__exit__)
        browser.size(width, 900, mobile=width < 600)
        browser.prefer(scheme)
        self.assertEqual(check(browser, page, None), [])
        return browser

    def altered(self, keep, change):
        """scan_05 with fewer and other rows."""
        lines = (SCANS / "scan_05.csv").read_text().splitlines()
        head = [line for line in lines if line.startswith("#") and not line.startswith("# block")]
        names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
        rows = [dict(zip(names, row)) for row in rows]
        rows = [row for row in rows if keep(row)]
        for i, row in enumerate(rows):
            row["index"] = str(i)
            change(row)
        body = [",".join(names)] + [",".join(row[name] for name in names) for row in rows]
        return self.write("altered.csv", "\n".join(head + body) + "\n")

    @unittest.skipUnless(find_chromium(), "no Chromium")
    def test_the_page_tells_what_the_answer_tells(self):
        browser = self.opened(self.page(SCANS / "scan_01.csv", "--json", "answer.json"), 1200, "light")
        answer = json.loads((self.folder / "answer.json").read_text())
        text = browser.evaluate("document.body.innerText")
        for words in ("of the gap", "95 % interval", "Before: where the base model misses", "scan_01.csv", answer["data"]["sha256"]):
            self.assertIn(words, text)
        # One bar for each cause, one for all that can't be told from it.
        bars = browser.evaluate("[...document.querySelectorAll('.bar-row:not(.bar-head):not(.faint) .bar-label')].map(b => b.innerText)")
        sets = {cause["effect"]: [cause["effect"]] for cause in answer["causes"]}
        for names in answer["ambiguity_sets"]:
            sets.update({name: names for name in names})
        causes = {tuple(sets[cause["effect"]]) for cause in answer["causes"]}
        self.assertEqual(len(bars), len(causes))
        for names in causes:
            self.assertTrue(any(bar.startswith("one of ") for bar in bars) or len(names) == 1, bars)
        for cause in answer["causes"]:
            for name in cause["parameters"]:
                self.assertIn(name, text)
        if answer["next_scan"]:
            # What a press of the link saves is the plan.
            plan = browser.evaluate("decodeURIComponent(document.querySelector('a.download').href.split(',')[1])")
            self.assertIn(f'menu = "{answer["next_scan"][0]["menu"]}"', plan)
            self.assertIn("umov scan next.toml", text)
        else:
            self.assertIn("No rivals are left", text)
        kinds = browser.evaluate("[...document.querySelectorAll('.chart')].map(c => c.dataset.figure)")
        self.assertEqual({"gap", "maps", "signature", "trace"}, set(kinds))
        # Three wavelengths, five channels, before and after.
        self.assertEqual(browser.evaluate("document.querySelector('[data-figure=maps]').data.filter(t => t.type === 'heatmap').length"), 30)

    @unittest.skipUnless(find_chromium(), "no Chromium")
    def test_one_wavelength_without_polarisers_on_a_phone_in_the_dark(self):
        def unpolarised(row):
            row["polarizer_deg"] = row["analyzer_deg"] = "open"

        scan = self.altered(lambda row: row["wavelength_nm"] == "633" and row["polarizer_deg"] == row["analyzer_deg"] == "0", unpolarised)
        browser = self.opened(self.page(scan, "--quick"), 390, "dark")
        self.assertIn("one wavelength only", browser.evaluate("document.body.innerText"))
        self.assertEqual(browser.evaluate("document.documentElement.dataset.theme"), "dark")
        self.assertIn(browser.evaluate("document.querySelector('[data-figure=maps]').data.filter(t => t.type === 'heatmap').length"), (1, 2))

    def test_the_catalogue_is_listed(self):
        text = self.must("diagnose", "--effects").stdout
        self.assertIn("backlash", text)
        self.assertIn("gap_deg / deg: whole play", text)
        listed = json.loads(self.must("--json", "diagnose", "--effects").stdout)
        names = [entry["effect"] for entry in listed]
        for name in ("incidence_zero", "lockin_phase", "fluorescence", "sample_model"):
            self.assertIn(name, names)
        drift = listed[names.index("laser_drift")]
        self.assertEqual(drift["stage"], "source")
        self.assertEqual(drift["parameters"][0]["name"], "total")
        self.assertTrue(drift["physics"])
        self.refused("diagnose", says=["no scan"])


if __name__ == "__main__":
    unittest.main()
