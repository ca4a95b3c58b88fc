"""The degree of linear polarisation in the mirror direction tells how glossy and how bright a paint is."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools" / "studies"))
import dolp  # noqa: E402


class DolpTellsGloss(unittest.TestCase):
    def test_black_paints_order_by_gloss_and_red_depolarises_where_it_is_bright(self):
        found = {key: value for key, (value, _) in dolp.measure().items()}
        matte, semi, gloss = (found[paint, 532, 30] for paint in ("black-matte", "black-semi-gloss", "black-gloss"))
        self.assertLess(matte, semi)
        self.assertLess(semi, gloss)
        self.assertGreater(gloss, 0.9)
        self.assertGreater(found["red-gloss", 532, 30], 0.9)
        self.assertLess(found["red-gloss", 633, 30], found["red-gloss", 532, 30])
        # Brewster's angle: the surface reflects no P light.
        self.assertLess(found["red-gloss", 633, 56], 0.5 * found["red-gloss", 633, 30])


if __name__ == "__main__":
    unittest.main()
