"""Updating the emulated board over USB: from its program to the boot loader and back, with Linux' own
drivers, by umov and by dfu-util."""

import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import unittest

from lab_case import LabCase, devices, wait_until

IMAGE = os.environ.get("UMOV_BOARD_IMAGE", "")
BOOT_LOADER = IMAGE.replace(".elf", "-boot.elf")
ROOT = pathlib.Path(__file__).resolve().parents[2]
KEY = ROOT / "firmware/boot/development.key"


def ids():
    """Vendor and product of everything of ours that the kernel has enumerated."""
    return [(path / "idProduct").read_text().strip()
            for path in pathlib.Path("/sys/bus/usb/devices").glob("*")
            if (path / "idVendor").exists() and (path / "idVendor").read_text().strip() == "1209"]


@unittest.skipUnless(os.path.exists(IMAGE), "the image of the controller board was not built")
class Update(LabCase):
    def signed(self, name, version):
        self.must("device", "sign", IMAGE.replace(".elf", ".bin"), "--key", KEY, "--version", version, "-o", name)
        return name

    def test_an_update_through_libusb_is_installed_and_runs(self):
        _, serial = self.plug_in("--image", IMAGE, "--boot-loader", BOOT_LOADER)
        newer = self.signed("newer.dfu", "0.9.0")
        told = json.loads(self.must("device", "flash", newer, "--backup", "old.bin", "--json", timeout=120).stdout)
        self.assertEqual((told["device"], told["version"]), (f"usb:{serial}", "0.9.0"))
        self.assertEqual((self.folder / "old.bin").read_bytes(),
                         pathlib.Path(IMAGE.replace(".elf", ".bin")).read_bytes())
        self.assertEqual(ids(), ["0001"], "the program runs")

    def hanging(self, name):
        """The image of the build, properly signed as 0.9.1, that waits for ever in its first instruction."""
        image = bytearray(pathlib.Path(IMAGE.replace(".elf", ".bin")).read_bytes())
        entry = struct.unpack_from("<I", image, 512 + 4)[0] & ~1
        struct.pack_into("<HH", image, entry - 0x08020000, 0xBF30, 0xE7FD)  # wfi; b .-2
        (self.folder / "raw.bin").write_bytes(image)
        self.write("hash.hpp", "0x0badc0de")
        board = struct.unpack_from("24s", image, 16)[0].rstrip(b"\0").decode()
        subprocess.run([sys.executable, ROOT / "firmware/boot/tools/sign_image.py", "sign", "--key", KEY, "--board", board,
                        "--version", "0.9.1", "--source-hash", "hash.hpp", "--binary", "hang.bin", "--dfu", name,
                        "--header", "header", "raw.bin"], cwd=self.folder, check=True, timeout=120)
        return name

    @unittest.skipUnless(os.environ.get("UMOV_LONG"), "two minutes for a trial that fails: set UMOV_LONG=1")
    def test_an_image_that_hangs_is_given_up_and_the_user_is_told(self):
        self.plug_in("--image", IMAGE, "--boot-loader", BOOT_LOADER)
        done = self.umov("device", "flash", self.hanging("hang.dfu"), timeout=400)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("gone back to the image before: image 0.9.1 failed its trial: the watchdog", done.stderr)
        self.assertEqual(ids(), ["0001"], "the program before it runs")
        self.assertIn("rolled_back (image 0.9.1", self.must("device", "log", "--device", "usb", "--clear").stdout)

    @unittest.skipUnless(os.environ.get("UMOV_LONG"), "a minute for a second update: set UMOV_LONG=1")
    @unittest.skipUnless(shutil.which("dfu-util"), "no dfu-util (apt install dfu-util)")
    def test_dfu_util_updates_it_too(self):
        _, serial = self.plug_in("--image", IMAGE, "--boot-loader", BOOT_LOADER)
        newer = self.signed("newer.dfu", "0.9.0")
        subprocess.run(["dfu-util", "-d", "1209:0001,1209:0002", "-e"], capture_output=True, timeout=60, check=False)
        wait_until(lambda: ids() == ["0002"], "the boot loader appears", 30)
        waiting = devices()[f"usb:{serial}"]
        self.assertTrue(waiting["boot_loader"])
        self.assertTrue(waiting["about"].endswith("waits for an image (umov device flash)"), waiting["about"])
        done = subprocess.run(["dfu-util", "-d", "1209:0002", "-a", "0", "-D", self.folder / newer], text=True,
                              capture_output=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        read = subprocess.run(["dfu-util", "-d", "1209:0002", "-a", "0", "-U", self.folder / "read.bin"], text=True,
                              capture_output=True, timeout=120, check=False)
        self.assertEqual(read.returncode, 0, read.stdout + read.stderr)
        sent = (self.folder / newer).read_bytes()[:-16]
        self.assertEqual((self.folder / "read.bin").read_bytes(), sent)


if __name__ == "__main__":
    unittest.main()
