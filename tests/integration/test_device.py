"""What umov device does with a controller: settings, self-test, a serial line."""

import json
import os
import pty
import select
import socket
import threading
import tty
import unittest

from umov_case import UmovCase


class Device(UmovCase):
    def test_settings_are_shown_changed_saved_and_set_back(self):
        _, device = self.emulator("--sample", "white-99")
        on = ("--device", device)
        changed = json.loads(self.must("device", "config", "set", "detector", "speed_deg_s=12", "--json", *on).stdout)
        self.assertEqual(changed["speed_deg_s"], 12)
        self.must("device", "config", "set", "lockin", "reference_hz=370", "harmonic=3", *on)
        every = json.loads(self.must("device", "config", "get", "--json", *on).stdout)
        self.assertEqual([axis["axis"] for axis in every["axes"]],
                         ["incidence", "detector", "azimuth", "polarizer", "analyzer", "filter"])
        self.assertEqual((every["axes"][1]["speed_deg_s"], every["lockin"]["harmonic"]), (12, 3))
        self.must("device", "config", "save", *on)
        self.must("device", "config", "defaults", *on)
        lockin = json.loads(self.must("device", "config", "get", "lockin", "--json", *on).stdout)
        self.assertEqual((lockin["reference_hz"], lockin["harmonic"]), (1000, 1))
        self.refused("device", "config", "set", "lockin", "colour=1", *on, says=["'colour'", "reference_hz"])
        self.refused("device", "config", "get", "arm", *on, says=["no axis 'arm'"])

    def test_a_command_without_a_device_says_that_it_is_an_emulated_one(self):
        for command in (("jog", "detector", "3"), ("home", "filter"), ("log",), ("selftest",), ("config", "save"), ("info",)):
            self.assertIn("no --device given", self.must("device", *command).stderr, command)
            self.assertEqual(self.must("device", *command, "--quiet").stderr, "", command)
            self.assertEqual(self.must("device", *command, "--device", "emulator").stderr, "", command)

    def test_a_selftest_finds_what_is_wrong_and_says_what_to_look_at(self):
        still = self.must("device", "selftest", "--json").stdout
        self.assertEqual({check["outcome"] for check in json.loads(still)}, {"good", "skipped"})
        whole = json.loads(self.must("device", "selftest", "--move", "--preset", "realistic", "--json").stdout)
        self.assertEqual({check["outcome"] for check in whole}, {"good"})
        self.assertIn("laser 814 nm, shutter", [check["check"] for check in whole])
        for parameter, culprit in (("laser.633.monitor_v=0.001", "laser 633 nm"),
                                   ("amplifier.pickup_v=0.1", "dark, gain 1")):
            done = self.umov("device", "selftest", "--move", "--plant-set", parameter)
            self.assertEqual(done.returncode, 1, parameter)
            self.assertIn(f"the self-test fails: {culprit}", done.stderr)
            failed = [line for line in done.stdout.splitlines() if line.startswith("FAILED")]
            self.assertTrue(failed[0].split(None, 1)[1].startswith(culprit), failed)

    def test_a_scan_over_a_serial_line_gives_every_record_once(self):
        _, device = self.emulator("--sample", "red-gloss")
        _, host, port = device.split(":")
        near, far = pty.openpty()
        tty.setraw(near)
        self.addCleanup(os.close, near)
        self.addCleanup(os.close, far)
        over = threading.Event()
        self.addCleanup(over.set)

        def bridge():
            with socket.create_connection((host, int(port))) as link:
                while not over.is_set():
                    ready, _, _ = select.select([near, link], [], [], 0.1)
                    if near in ready:
                        link.sendall(os.read(near, 4096))
                    if link in ready:
                        os.write(near, link.recv(4096))

        thread = threading.Thread(target=bridge, daemon=True)
        thread.start()
        self.write("plan.toml", 'sample = "red gloss"\nwavelengths_nm = [532]\ntheta_i_deg = [30]\n'
                                'theta_r_deg = { from = -60, to = 60, step = 5 }\nstates = [["P", "P"]]\ndwell_ms = 10\n')
        line = f"serial:{os.ttyname(far)}"
        self.assertIn(line, self.must("device", "info", "--device", line).stdout)
        self.must("scan", "plan.toml", "-o", "scan.h5", "--device", line + "?baud=115200")
        over.set()
        thread.join()
        self.must("export", "scan.h5", "-o", "scan.csv")
        rows = [row for row in (self.folder / "scan.csv").read_text().splitlines() if row[:1].isdigit()]
        self.assertEqual([int(row.split(",")[0]) for row in rows], list(range(25)))


if __name__ == "__main__":
    unittest.main()
