"""The image that is flashed, on the emulated chip, at Linux' own USB drivers."""

import os
import unittest

from lab_case import LabCase, controllers

IMAGE = os.environ.get("UMOV_BOARD_IMAGE", "")

# Short moves: an emulated processor in an emulated machine makes some thousand steps a second.
PLAN = """
sample = "red gloss"
wavelengths_nm = [532]
theta_i_deg = [0.5]
theta_r_deg = { from = -0.5, to = 0.5, step = 0.5 }
states = [["P", "P"]]
dwell_ms = 10
settle_ms = 2
"""


@unittest.skipUnless(os.path.exists(IMAGE), "the image of the controller board was not built")
class Board(LabCase):
    references = {}

    def plan(self, step):
        return self.write("plan.toml", PLAN)

    def test_scans_with_the_flashed_image_give_the_records_of_the_native_core_bit_for_bit(self):
        reference = self.reference("board")
        _, serial = self.plug_in("--image", IMAGE)
        self.assertEqual(serial, "333137363234510A00300041", "the chip's number")
        self.assertEqual((controllers()[0] / "bNumInterfaces").read_text().strip(), "4")
        for device in ("usb", "hid"):
            self.must("scan", "plan.toml", "-o", f"{device}.h5", "--device", device, timeout=300)
            self.expect_same_records(self.folder / f"{device}.h5", reference, 3)


if __name__ == "__main__":
    unittest.main()
