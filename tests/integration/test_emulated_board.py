"""The image of the controller board on an emulated chip, served like an instrument."""

import os
import pathlib
import unittest

from umov_case import UmovCase

IMAGE = os.environ.get("UMOV_BOARD_IMAGE", "")

PLAN = """sample = "red gloss"
wavelengths_nm = [532]
theta_i_deg = [2]
theta_r_deg = [1, 2, 3]
states = [["P", "P"]]
dwell_ms = 10
"""


@unittest.skipUnless(IMAGE, "no cross compiler or no libunicorn: the board's image was not built")
class EmulatedBoard(UmovCase):
    def test_a_scan_with_the_flashed_image(self):
        _, device = self.emulator("--sample", "red-gloss", "--image", IMAGE)
        info = self.must("device", "info", "--device", device).stdout
        self.assertIn("umov stm32f407", info)
        (self.folder / "plan.toml").write_text(PLAN, encoding="utf-8")
        self.must("scan", "plan.toml", "--device", device, "-o", "scan.h5")
        exported = self.must("export", "scan.h5", "-o", "scan.csv")
        rows = [line for line in (self.folder / "scan.csv").read_text(encoding="utf-8").splitlines()
                if line[:1].isdigit()]
        self.assertEqual(len(rows), 3, exported.stdout)
        self.assertTrue(all(float(row.split(",")[10]) > 1e-4 for row in rows), rows)

    def test_images_are_signed_with_a_key_of_ones_own(self):
        image = IMAGE.replace(".elf", ".dfu")
        self.must("device", "key", "lab.key")
        self.refused("device", "key", "lab.key", says=["never overwritten"])
        self.assertEqual((self.folder / "lab.key").stat().st_mode & 0o077, 0, "for its owner's eyes")
        for name in ("one.bin", "again.bin"):
            self.must("device", "sign", image, "--key", "lab.key", "--version", "1.2.3", "-o", name)
        one = (self.folder / "one.bin").read_bytes()
        self.assertEqual(one, (self.folder / "again.bin").read_bytes())
        self.assertNotEqual(one[64:128], pathlib.Path(IMAGE.replace(".elf", ".bin")).read_bytes()[64:128])
        (self.folder / "cut.bin").write_bytes(one[:-8])
        self.refused("device", "flash", "cut.bin", says=["cut.bin", "its header says"])
        (self.folder / "changed.bin").write_bytes(one[:-8] + b"otherwise"[:8])
        self.refused("device", "flash", "changed.bin", says=["changed.bin", "CRC"])
        self.refused("device", "sign", image, "--key", "one.bin", "-o", "two.bin", says=["one.bin:1", "key"])
        (self.folder / "lines.toml").write_text("[reset]\nchip = 'no such chip'\nboot0 = 0\n", encoding="utf-8")
        self.refused("device", "flash", image, "--quiet", "--rom", "lines.toml", says=["lines.toml", "nrst"])
        (self.folder / "lines.toml").write_text("[reset]\nchip = 'no such chip'\nboot0 = 0\nnrst = 1\n",
                                                encoding="utf-8")
        self.refused("device", "flash", image, "--quiet", "--rom", "lines.toml", says=["no such GPIO chip"])
        self.refused("device", "flash", image, "--device", "tcp:localhost:1", says=["over USB"])

    def test_an_image_that_is_none_is_refused(self):
        (self.folder / "image.elf").write_text("no image", encoding="utf-8")
        self.refused("emulator", "--sample", "red-gloss", "--image", "image.elf", says=["image.elf", "ELF"])


if __name__ == "__main__":
    unittest.main()
