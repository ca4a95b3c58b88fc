"""The image that is flashed, on the emulated chip, at Linux' own USB drivers."""

import os
import unittest

from lab_case import LabCase, controllers, rows_of

IMAGE = os.environ.get("UMOV_BOARD_IMAGE", "")


@unittest.skipUnless(os.path.exists(IMAGE), "the image of the controller board was not built")
class Board(LabCase):
    def test_scans_with_the_flashed_image_give_the_records_of_the_native_core_bit_for_bit(self):
        step = 20
        reference = self.reference(step)
        _, serial = self.plug_in("--image", IMAGE)
        self.assertEqual(serial, "333137363234510A00300041", "the chip's number")
        self.assertEqual((controllers()[0] / "bNumInterfaces").read_text().strip(), "4")
        for device in ("usb", "hid"):
            self.must("scan", "plan.toml", "-o", f"{device}.h5", "--device", device, timeout=300)
            self.expect_same_records(self.folder / f"{device}.h5", reference, rows_of(step))


if __name__ == "__main__":
    unittest.main()
