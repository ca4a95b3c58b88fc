"""The image that is flashed, on the emulated chip, at Linux' own USB drivers."""

import os
import unittest

import h5py

from lab_case import LabCase, chip_of_adapter, controllers, set_line, wait_until

INTERLOCK = 2
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

    def test_an_interlock_opened_at_the_adapter_ends_a_scan_with_the_flashed_image(self):
        self.plug_in("--image", IMAGE, "--gpio-adapter")
        chip = wait_until(chip_of_adapter, "the driver makes a GPIO chip")
        self.write("plan.toml", PLAN.replace("step = 0.5", "step = 0.02"))
        scan = self.start("scan", "--quiet", "plan.toml", "-o", "scan.h5", "--device", "usb")
        self.wait_for_records(scan, 5_000, 200)
        set_line(chip, INTERLOCK, 0)
        _, message = scan.communicate(timeout=60)
        self.assertEqual(scan.returncode, 1, message)
        self.assertIn("interlock", message)
        self.assertEqual(self.fault(), ("interlock", "open"))
        self.refused("device", "log", "--clear", "--device", "usb", says=["a fault is latched"])
        set_line(chip, INTERLOCK, 1)
        self.assertEqual(self.fault(), ("interlock", "closed"), "latched until somebody clears it")
        self.assertIn("cleared interlock", self.must("device", "log", "--clear", "--device", "usb").stdout)
        self.must("scan", "plan.toml", "-o", "scan.h5", "--device", "usb", "--resume", timeout=300)
        with h5py.File(self.folder / "scan.h5") as whole:
            self.assertEqual(list(whole["records/index"][:]), list(range(51)))


if __name__ == "__main__":
    unittest.main()
