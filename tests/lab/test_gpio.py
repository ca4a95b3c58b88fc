"""The GPIO adapter under Linux' own driver: the interlock, BOOT0 and NRST through libgpiod."""

import os
import signal
import subprocess
import unittest

from lab_case import LabCase, chip_of_adapter, set_line, wait_until

BOOT0, NRST, INTERLOCK = 0, 1, 2
IMAGE = os.environ.get("UMOV_BOARD_IMAGE", "").replace(".elf", ".dfu")


class Gpio(LabCase):
    def setUp(self):
        super().setUp()
        self.process, _ = self.plug_in("--gpio-adapter")
        self.chip = wait_until(chip_of_adapter, "the driver makes a GPIO chip")

    def set(self, line, level):
        set_line(self.chip, line, level)

    def get(self, line):
        out = subprocess.run(["gpioget", self.chip, str(line)], check=True, timeout=20,
                             capture_output=True, text=True).stdout
        return int(out)

    def test_the_chip_has_four_lines_at_the_levels_of_the_board(self):
        label = subprocess.run(["gpioinfo", self.chip], capture_output=True, text=True, check=True).stdout
        self.assertIn("4 lines", label)
        self.assertEqual([self.get(line) for line in (BOOT0, NRST, INTERLOCK)], [0, 1, 1])

    def test_an_interlock_opened_in_mid_scan_ends_it_dark_and_is_cleared_by_hand(self):
        self.plan(0.1)
        scan = self.start("scan", "--quiet", "plan.toml", "-o", "scan.h5", "--device", "usb")
        self.wait_for_records(scan, 5_000)
        self.set(INTERLOCK, 0)
        _, message = scan.communicate(timeout=60)
        self.assertEqual(scan.returncode, 1, message)
        self.assertIn("interlock", message)
        self.assertEqual(self.fault(), ("interlock", "open"))
        self.refused("device", "log", "--clear", "--device", "usb", says=["a fault is latched"])
        self.set(INTERLOCK, 1)
        self.assertEqual(self.fault(), ("interlock", "closed"), "latched until somebody clears it")
        self.assertIn("cleared interlock", self.must("device", "log", "--clear", "--device", "usb").stdout)
        self.must("scan", "plan.toml", "-o", "scan.h5", "--device", "usb", "--resume")

    def test_reset_and_boot_lines_reach_the_board(self):
        self.set(BOOT0, 1)
        self.set(NRST, 0)
        self.assertEqual([self.get(NRST)], [1], "as an input it is let go: the board pulls it up")
        self.process.send_signal(signal.SIGINT)
        _, told = self.process.communicate(timeout=20)
        self.assertIn("NRST is low, BOOT0 high", told)

    @unittest.skipUnless(os.path.exists(IMAGE), "the image of the controller board was not built")
    def test_flashing_by_the_rom_loader_pulls_the_lines_and_tells_that_no_chip_answers(self):
        self.write("lines.toml", '[reset]\nchip = "mcp2221_gpio"\nboot0 = 0\nnrst = 1\n')
        self.refused("device", "flash", IMAGE, "--rom", "lines.toml", "--quiet", says=["0483:df11", "does not appear"])
        self.assertEqual([self.get(line) for line in (BOOT0, NRST)], [0, 1], "let go again")
        self.process.send_signal(signal.SIGINT)
        _, told = self.process.communicate(timeout=20)
        self.assertIn("NRST is low, BOOT0 high", told)


if __name__ == "__main__":
    unittest.main()
