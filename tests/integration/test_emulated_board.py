"""The image of the controller board on an emulated chip, served like an instrument."""

import os
import pathlib
import re
import socket
import struct
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

    @staticmethod
    def gdb(pipe, packet):
        """Asks a gdb stub and returns the packet that answers."""
        pipe.sendall(f"${packet}#{sum(packet.encode()) % 256:02x}".encode())
        answer = b""
        while answer.count(b"#") < 1 or len(answer.split(b"#")[-1]) < 2:
            answer += pipe.recv(4096)
        return answer.split(b"$", 1)[1].split(b"#")[0].decode()

    def test_a_debugger_stops_the_image_and_the_adapter_is_beside_it(self):
        process = self.start("emulator", "--sample", "red-gloss", "--image", IMAGE, "--usb", "--port", "0",
                             "--gpio-adapter", "--gdb", "0")
        debugger = int(re.search(r"localhost:(\d+)", process.stdout.readline())[1])
        usb = int(re.search(r"--tcp-port (\d+)", process.stdout.readline())[1])
        with socket.create_connection(("127.0.0.1", usb), timeout=10) as pipe:
            pipe.sendall(struct.pack(">HHI", 0x0111, 0x8005, 0))
            listing = b""
            while part := pipe.recv(4096):
                listing += part
        self.assertEqual(struct.unpack(">I", listing[8:12])[0], 2)
        self.assertIn(b"1-1\0", listing)
        self.assertIn(struct.pack(">HH", 0x04D8, 0x00DD), listing, "the MCP2221A")
        with socket.create_connection(("127.0.0.1", debugger), timeout=10) as pipe:
            self.assertEqual(self.gdb(pipe, "?"), "S05")
            registers = struct.unpack("<17I", bytes.fromhex(self.gdb(pipe, "g")))
            self.assertTrue(0x08020000 <= registers[15] < 0x08038000, "in the image")
            self.assertEqual(self.gdb(pipe, "s"), "S05")
        self.refused("emulator", "--sample", "red-gloss", "--gdb", "0", says=["--image"])

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
        self.refused("device", "flash", image, "--quiet", "--rom", "lines.toml", says=["GPIO chip"])
        self.refused("device", "flash", image, "--device", "tcp:localhost:1", says=["over USB"])
        self.refused("device", "flash", image, "--quiet", "--backup", "nowhere/old.bin",
                     says=["nowhere/old.bin", "the folder does not exist"])  # before the controller is looked for

    def test_an_image_that_is_none_is_refused(self):
        (self.folder / "image.elf").write_text("no image", encoding="utf-8")
        self.refused("emulator", "--sample", "red-gloss", "--image", "image.elf", says=["image.elf", "ELF"])


if __name__ == "__main__":
    unittest.main()
