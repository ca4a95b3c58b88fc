"""Nothing recorded is lost or doubled: kill -9, Ctrl-C, a dropped link, an emulator that dies."""

import csv
import signal
import socket
import threading
import time
import unittest

from umov_case import UmovCase

PLAN = """
sample = "red gloss"
wavelengths_nm = [532, 633]
theta_i_deg = [30, 60]
theta_r_deg = { from = -60, to = 60, step = 1 }
states = [["P", "P"], ["P", "S"]]
dwell_ms = 20
"""
ROWS = 2 * 2 * 121 * 2


class Relay:
    """A TCP relay whose link can be cut: what the host sees when a cable is pulled."""

    def __init__(self, port):
        self.target = port
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.pairs = []
        self.carried = 0
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                client, _ = self.server.accept()
                device = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                return
            self.pairs.append((client, device))
            threading.Thread(target=self.carry, args=(client, device), daemon=True).start()
            threading.Thread(target=self.carry, args=(device, client), daemon=True).start()

    def carry(self, source, sink):
        try:
            while data := source.recv(4096):
                self.carried += len(data)
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            end.close()

    def cut(self):
        for pair in self.pairs:
            for end in pair:
                try:
                    end.shutdown(socket.SHUT_RDWR)
                except OSError:
                    pass
        self.pairs.clear()


class ScanSurvives(UmovCase):
    def setUp(self):
        super().setUp()
        self.write("plan.toml", PLAN)

    def records(self, file):
        self.must("export", file, "--format", "csv", "-o", "out.csv", "--force")
        with open(self.folder / "out.csv", encoding="utf-8") as stream:
            rows = [line for line in stream if not line.startswith("#")]
        return list(csv.DictReader(rows))

    def indices(self, file):
        return [int(row["index"]) for row in self.records(file)]

    def expect_whole(self, file="scan.h5"):
        rows = self.records(file)
        self.assertEqual([int(row["index"]) for row in rows], list(range(ROWS)))
        times = [float(row["time_s"]) for row in rows]
        back = [i for i in range(1, ROWS) if times[i] < times[i - 1]]
        self.assertEqual(back, [], "time goes backwards at these rows")
        with open(self.folder / "out.csv", encoding="utf-8") as stream:
            self.assertIn("# sample: red gloss\n", stream.readlines())

    def wait_for_journal(self, process, bytes_at_least):
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            self.assertIsNone(process.poll(), "the scan ended before it could be disturbed")
            journals = list(self.folder.glob("*.journal"))
            if journals and journals[0].stat().st_size > bytes_at_least:
                return
            time.sleep(0.005)
        self.fail("no journal grows")

    def test_kill_9_in_mid_scan_then_resume_has_every_record_once(self):
        scan = self.start("scan", "plan.toml", "-o", "scan.h5")
        self.wait_for_journal(scan, 20_000)
        scan.kill()
        scan.wait()
        self.assertFalse((self.folder / "scan.h5").exists())
        self.must("scan", "plan.toml", "-o", "scan.h5", "--resume")
        self.expect_whole()

    def test_kill_9_with_an_emulator_that_lives_on(self):
        _, device = self.emulator("--sample", "red-gloss")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 20_000)
        scan.kill()
        scan.wait()
        self.must("scan", "plan.toml", "-o", "scan.h5", "--device", device, "--resume")
        self.expect_whole()

    def test_ctrl_c_leaves_a_valid_file_and_resume_goes_on(self):
        scan = self.start("scan", "plan.toml", "-o", "scan.h5")
        self.wait_for_journal(scan, 20_000)
        scan.send_signal(signal.SIGINT)
        _, message = scan.communicate(timeout=20)
        self.assertEqual(scan.returncode, 130, message)
        self.assertIn("--resume", message)
        part = self.indices("scan.h5")
        self.assertEqual(part, list(range(len(part))))
        self.assertTrue(0 < len(part) < ROWS)
        self.must("scan", "plan.toml", "-o", "scan.h5", "--resume")
        self.expect_whole()

    def test_a_link_that_drops_twice_is_taken_up_again(self):
        _, device = self.emulator("--sample", "red-gloss")
        relay = Relay(int(device.rsplit(":", 1)[1]))
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", f"tcp:127.0.0.1:{relay.port}")
        for size in (15_000, 60_000):
            self.wait_for_journal(scan, size)
            relay.cut()
        _, message = scan.communicate(timeout=60)
        self.assertEqual(scan.returncode, 0, message)
        self.expect_whole()

    def test_an_emulator_that_dies_leaves_a_scan_that_another_can_finish(self):
        emulator, device = self.emulator("--sample", "red-gloss")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 20_000)
        emulator.kill()
        _, message = scan.communicate(timeout=60)
        self.assertEqual(scan.returncode, 1, message)
        self.assertIn("--resume", message)
        _, device = self.emulator("--sample", "red-gloss")
        self.must("scan", "plan.toml", "-o", "scan.h5", "--device", device, "--resume")
        self.expect_whole()

    def test_resume_on_another_sample_is_refused(self):
        options = ("scan", "plan.toml", "-o", "scan.h5", "--sample")
        scan = self.start(*options, "red-gloss")
        self.wait_for_journal(scan, 10_000)
        scan.kill()
        scan.wait()
        journal = (self.folder / "scan.h5.journal").read_bytes()
        self.refused(*options, "white-99", "--resume", says=["begun on", "same instrument"])
        self.refused(*options, "red-gloss", "--seed", "2", "--resume", says=["begun on"])
        self.assertEqual((self.folder / "scan.h5.journal").read_bytes()[:len(journal)], journal)
        self.must(*options, "red-gloss", "--resume")
        self.expect_whole()

    def test_force_takes_over_a_controller_that_runs_another_program(self):
        _, device = self.emulator("--sample", "red-gloss")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 20_000)
        scan.kill()
        scan.wait()
        self.write("small.toml", PLAN.replace("step = 1", "step = 30"))
        self.must("scan", "small.toml", "-o", "small.h5", "--device", device, "--force")
        self.assertEqual(self.indices("small.h5"), list(range(2 * 2 * 5 * 2)))

    def test_ctrl_c_while_a_lost_link_is_retried_ends_as_interrupted(self):
        emulator, device = self.emulator("--sample", "red-gloss")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 20_000)
        emulator.kill()
        emulator.wait()
        time.sleep(1.5)
        scan.send_signal(signal.SIGINT)
        _, message = scan.communicate(timeout=10)
        self.assertEqual(scan.returncode, 130, message)
        self.assertIn(f"--device {device} --resume", message)
        self.assertTrue(0 < len(self.records("scan.h5")) < ROWS)

    def test_ctrl_c_while_homing_leaves_nothing_and_says_so(self):
        _, device = self.emulator("--sample", "red-gloss", "--real-time")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        time.sleep(1.5)  # homing takes much longer
        scan.send_signal(signal.SIGINT)
        _, message = scan.communicate(timeout=10)
        self.assertEqual(scan.returncode, 130, message)
        self.assertIn("before anything was measured", message)
        self.assertEqual([path.name for path in self.folder.glob("scan*")], [])

    def test_a_paused_scan_lets_an_axis_be_moved_and_goes_on(self):
        _, device = self.emulator("--sample", "red-gloss")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 20_000)
        scan.send_signal(signal.SIGINT)
        _, message = scan.communicate(timeout=20)
        self.assertEqual(scan.returncode, 130, message)
        time.sleep(3.5)  # longer than the controller waits for a host while it moves or shines
        self.assertIn("state paused, fault none", self.must("device", "info", "--device", device).stdout)
        self.must("device", "home", "azimuth", "--device", device, timeout=20)
        moved = self.must("device", "jog", "detector", "12", "--device", device, timeout=20)
        self.assertIn("detector 12.0000", moved.stdout)
        self.must("scan", "plan.toml", "-o", "scan.h5", "--device", device, "--resume")
        self.expect_whole()

    def test_the_fault_that_a_killed_scan_leaves_is_cleared_and_named(self):
        _, device = self.emulator("--sample", "red-gloss")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 20_000)
        scan.kill()
        scan.wait()
        time.sleep(3.5)
        self.assertIn("cleared link_lost", self.must("device", "log", "--clear", "--device", device).stdout)
        self.assertIn("fault none", self.must("device", "info", "--device", device).stdout)

    def test_a_scan_that_is_stopped_for_longer_than_the_heartbeat_goes_on_and_says_so(self):
        _, device = self.emulator("--sample", "red-gloss", "--real-time")
        self.write("slow.toml", PLAN.replace("[532, 633]", "[532]").replace("[30, 60]", "[30]").replace("step = 1", "step = 2"))
        scan = self.start("scan", "slow.toml", "-o", "scan.h5", "--device", device)
        self.wait_for_journal(scan, 4_000)
        scan.send_signal(signal.SIGSTOP)
        time.sleep(4)  # the controller waits 3 s for a host while it moves or shines
        scan.send_signal(signal.SIGCONT)
        _, message = scan.communicate(timeout=100)
        self.assertEqual(scan.returncode, 0, message)
        self.assertEqual(message.count("link_lost"), 1, message)
        rows = self.records("scan.h5")
        self.assertEqual([int(row["index"]) for row in rows], list(range(61 * 2)))
        times = [float(row["time_s"]) for row in rows]
        self.assertEqual(times, sorted(times))
        self.assertIn("link_lost", self.must("device", "log", "--device", device).stdout)

    def test_numbers_for_the_controller_are_read_whole_and_in_range(self):
        for setting in ("max_deg=4300", "max_deg=85abc", "max_deg=nan", "speed_deg_s=-1", "max_deg"):
            self.refused("device", "config", "set", "detector", setting, "--device", "emulator", says=[setting.split("=")[-1]])
        for angle in ("nan", "inf", "12x", "2147.483648"):
            self.refused("device", "jog", "detector", angle, says=["angle"])

    def test_resume_with_another_plan_is_refused(self):
        scan = self.start("scan", "plan.toml", "-o", "scan.h5")
        self.wait_for_journal(scan, 10_000)
        scan.kill()
        scan.wait()
        self.write("plan.toml", PLAN.replace("step = 1", "step = 2"))
        self.refused("scan", "plan.toml", "-o", "scan.h5", "--resume", says=["plan"])

    def test_a_finished_scan_is_not_overwritten(self):
        self.write("small.toml", PLAN.replace("step = 1", "step = 30"))
        self.must("scan", "small.toml", "-o", "scan.h5")
        before = (self.folder / "scan.h5").read_bytes()
        self.refused("scan", "small.toml", "-o", "scan.h5", says=["scan.h5", "--force"])
        self.assertEqual((self.folder / "scan.h5").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
