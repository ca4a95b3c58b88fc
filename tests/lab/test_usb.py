"""The controller on USB under Linux' own drivers: enumeration, scans, unplugging, permissions."""

import json
import os
import pathlib
import re
import select
import signal
import struct
import subprocess
import time
import unittest

from lab_case import UMOV, LabCase, controllers, devices, rows_of, wait_until


class Usb(LabCase):
    def test_the_kernel_finds_four_interfaces_and_their_drivers(self):
        _, serial = self.plug_in()
        path = controllers()[0]
        read = lambda name: (path / name).read_text().strip()
        self.assertEqual((read("idVendor"), read("idProduct")), ("1209", "0001"))
        self.assertEqual(read("product"), "Umov reflectometer controller")
        self.assertEqual(read("speed"), "12")
        self.assertEqual(read("bNumInterfaces"), "4")
        self.assertRegex(serial, r"^EMU-[0-9a-f]{8}$")
        kinds = [(path / f"{path.name}:1.{n}" / "bInterfaceClass").read_text().strip() for n in range(4)]
        self.assertEqual(kinds, ["ff", "03", "03", "fe"])
        found = devices()
        self.assertTrue(found[f"usb:{serial}"]["accessible"])
        self.assertRegex(found[f"hid:{serial}"]["node"], "^/dev/hidraw[0-9]+$")

    def test_scans_over_bulk_pipes_and_reports_give_the_records_of_tcp_bit_for_bit(self):
        step = 6
        reference = self.reference(step)
        self.plug_in()
        for device in ("usb", "hid"):
            self.must("scan", "plan.toml", "-o", f"{device}.h5", "--device", device)
            self.expect_same_records(self.folder / f"{device}.h5", reference, rows_of(step))

    def scan_through_unplugging(self, device):
        step = 0.4
        reference = self.reference(step)
        self.serve_usbip()
        scan = self.start("scan", "--quiet", "--json", "plan.toml", "-o", "scan.h5", "--device", device)
        for size in (12_000, 36_000):
            self.wait_for_records(scan, size)
            self.detach()
            time.sleep(0.3)
            self.attach()
        out, message = scan.communicate(timeout=120)
        self.assertEqual(scan.returncode, 0, message)
        self.assertEqual(json.loads(out)["lost_links"], 2)
        self.expect_same_records(self.folder / "scan.h5", reference, rows_of(step))

    def test_a_cable_pulled_twice_in_a_bulk_scan_loses_and_doubles_nothing(self):
        self.scan_through_unplugging("usb")

    def test_a_cable_pulled_twice_in_a_report_scan_loses_and_doubles_nothing(self):
        self.scan_through_unplugging("hid")

    def test_a_second_program_is_told_who_has_the_controller(self):
        self.plug_in()
        self.plan(0.02)
        scan = self.start("scan", "--quiet", "plan.toml", "-o", "scan.h5", "--device", "usb")
        self.wait_for_records(scan, 3_000)
        self.refused("device", "info", "--device", "usb", says=[f"in use by umov (process {scan.pid})"])
        self.refused("device", "info", "--device", "hid", says=[os.uname().nodename])
        scan.send_signal(signal.SIGINT)
        _, message = scan.communicate(timeout=30)
        self.assertEqual(scan.returncode, 130, message)
        self.must("device", "info", "--device", "hid")

    def test_one_who_may_not_open_it_is_told_of_the_rule_and_the_rule_helps(self):
        _, serial = self.plug_in()

        def as_student(*arguments):
            return subprocess.run(["setpriv", "--reuid", "65534", "--regid", "65534", "--groups", "46",
                                   str(UMOV), *arguments], capture_output=True, text=True, check=False)
        plugdev = re.search(r"^plugdev:[^:]*:(\d+):", pathlib.Path("/etc/group").read_text(), re.M)
        self.assertEqual(plugdev[1], "46")
        for device in ("usb", "hid"):
            refused = as_student("device", "info", "--device", device)
            self.assertEqual(refused.returncode, 1)
            self.assertIn("may not open", refused.stderr)
            self.assertIn("umov device udev-rule | sudo tee", refused.stderr)
        rules = pathlib.Path("/run/udev/rules.d")
        rules.mkdir(parents=True, exist_ok=True)
        rule = rules / "60-umov.rules"
        rule.write_text(self.must("device", "udev-rule").stdout)
        self.addCleanup(rule.unlink)
        for command in (["control", "--reload"], ["trigger", "--subsystem-match=usb",
                        "--subsystem-match=hidraw"], ["settle"]):
            subprocess.run(["udevadm", *command], check=True, timeout=30)
        for device in ("usb", "hid"):
            allowed = as_student("device", "info", "--device", f"{device}:{serial}")
            self.assertEqual(allowed.returncode, 0, allowed.stderr)

    def test_a_hand_controller_moves_a_homed_axis(self):
        self.plug_in()
        self.must("device", "home", "detector", "--device", "usb")
        path = controllers()[0]
        node = next(path.glob(f"{path.name}:1.2/*/hidraw/*")).name
        with open(f"/dev/{node}", "r+b", buffering=0) as hand:
            def shown():
                return struct.unpack("<BBBBi", hand.read(8))
            detector = 1
            hand.write(b"\0" + struct.pack("<BBHi", detector, 0, 0, 2_000_000))
            position = None
            deadline = time.monotonic() + 10
            while position != 2_000_000 and time.monotonic() < deadline:
                if not select.select([hand], [], [], 1)[0]:
                    continue
                _, fault, _, axis, udeg = shown()
                self.assertEqual(fault, 0)
                if axis == detector:
                    position = round(udeg, -4)
            self.assertEqual(position, 2_000_000)
        info = self.must("device", "info", "--device", "usb", "--json").stdout
        self.assertRegex(info, r'"detector": (2\.0|1\.99)')

    def test_a_watcher_is_told_of_controllers_that_come_and_go(self):
        watcher = self.start("device", "list", "--watch", "--json")
        _, serial = self.serve_usbip()
        come = json.loads(watcher.stdout.readline())
        self.assertEqual((come["device"], come["present"]), (f"usb:{serial}", True))
        self.detach()
        gone = json.loads(watcher.stdout.readline())
        self.assertEqual((gone["device"], gone["present"]), (f"usb:{serial}", False))
        watcher.send_signal(signal.SIGINT)
        self.assertEqual(watcher.wait(timeout=20), 0)

    def test_names_that_fit_nothing_say_what_is_there(self):
        _, serial = self.plug_in()
        for kind in ("usb", "hid"):
            self.refused("device", "info", "--device", f"{kind}:NONE", says=["not plugged in", f"{kind}:{serial}"])


class NothingPluggedIn(LabCase):
    def test_no_controller_is_said_in_one_line(self):
        wait_until(lambda: not controllers(), "the last controller goes")
        for kind in ("usb", "hid"):
            self.refused("device", "info", "--device", kind, says=["no controller is plugged in"])


if __name__ == "__main__":
    unittest.main()
