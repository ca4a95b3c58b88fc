"""Updating the emulated board over USB: from its program to the boot loader and back, with Linux' own
drivers, by umov and by dfu-util."""

import json
import os
import pathlib
import shutil
import subprocess
import unittest

from lab_case import LabCase, wait_until

IMAGE = os.environ.get("UMOV_BOARD_IMAGE", "")
BOOT_LOADER = IMAGE.replace(".elf", "-boot.elf")
KEY = pathlib.Path(__file__).resolve().parents[2] / "firmware/boot/development.key"


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

    @unittest.skipUnless(os.environ.get("UMOV_LONG"), "a minute for a second update: set UMOV_LONG=1")
    @unittest.skipUnless(shutil.which("dfu-util"), "no dfu-util (apt install dfu-util)")
    def test_dfu_util_updates_it_too(self):
        self.plug_in("--image", IMAGE, "--boot-loader", BOOT_LOADER)
        newer = self.signed("newer.dfu", "0.9.0")
        subprocess.run(["dfu-util", "-d", "1209:0001,1209:0002", "-e"], capture_output=True, timeout=60, check=False)
        wait_until(lambda: ids() == ["0002"], "the boot loader appears", 30)
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
