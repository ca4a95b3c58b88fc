"""What runs inside the kernel lab: a fresh kernel with real USB, HID and GPIO drivers, as root."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
from umov_case import UMOV, UmovCase  # noqa: E402

# Noise depends on the instant at which a row is measured, which no two runs share: without it, the
# records of two runs are the same to the last bit.
QUIET_BENCH = ("--sample", "red-gloss", "--plant-set", "monitor.noise_v=0",
               "--plant-set", "amplifier.input_noise_v=0", "--plant-set", "amplifier.output_noise_v=0")

PLAN = """
sample = "red gloss"
wavelengths_nm = [532]
theta_i_deg = [30]
theta_r_deg = {{ from = -60, to = 60, step = {step} }}
states = [["P", "P"], ["P", "S"]]
dwell_ms = 10
"""


def rows_of(step):
    return 2 * (round(120 / step) + 1)


def devices():
    """`umov device list --json` as a dictionary by device string."""
    out = subprocess.run([UMOV, "device", "list", "--json"], capture_output=True, text=True, check=True)
    return {entry["device"]: entry for entry in json.loads(out.stdout)}


def wait_until(condition, what, seconds=20):
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        if time.monotonic() > deadline:
            raise AssertionError(f"{what}: not within {seconds} s")
        time.sleep(0.02)
    return found


def controllers():
    """Folders below /sys of the controllers that the kernel has enumerated."""
    return [path.parent for path in pathlib.Path("/sys/bus/usb/devices").glob("*/manufacturer")
            if path.read_text().strip() == "Umov"]


def chip_of_adapter():
    """The name that the kernel gave the GPIO adapter, or None. Its number may differ after a replug, its label does not."""
    listed = subprocess.run(["gpiodetect"], capture_output=True, text=True, check=False).stdout
    chips = [line.split()[0] for line in listed.splitlines() if "mcp2221_gpio" in line]
    return chips[-1] if chips else None


def set_line(chip, line, level):
    subprocess.run(["gpioset", chip, f"{line}={level}"], check=True, timeout=20)


class LabCase(UmovCase):
    def plug_in(self, *options):
        """An emulator plugged straight into this kernel; returns (process, serial number)."""
        process = self.start("emulator", *QUIET_BENCH, "--plug-in", *options)
        return process, self.serial_of(process)

    def serve_usbip(self, *options, port=3240):
        """An emulator served by USB/IP and attached once; returns (process, serial number)."""
        process = self.start("emulator", *QUIET_BENCH, "--usb", "--port", port, *options)
        self.assertIn("plug it in with", process.stdout.readline())
        self.attach(port)
        return process, self.serial_of(process)

    def serial_of(self, process):
        def found():
            self.assertIsNone(process.poll(), "the emulator has ended")
            ready = [path for path in controllers() if list(path.glob("*:1.1/*/hidraw/*"))]
            return ready[0] if ready else None
        path = wait_until(found, "the kernel enumerates the controller")
        return (path / "serial").read_text().strip()

    def attach(self, port=3240, bus_id="1-1"):
        subprocess.run(["usbip", "--tcp-port", str(port), "attach", "-r", "127.0.0.1", "-b", bus_id],
                       check=True, capture_output=True, timeout=20)

    def detach(self, port=0):
        subprocess.run(["usbip", "detach", "-p", str(port)], check=True, capture_output=True, timeout=20)

    def plan(self, step):
        return self.write("plan.toml", PLAN.format(step=step))

    references = {}

    def reference(self, step):
        """The records of the same plan over TCP, measured once; the plan is written anyway."""
        self.plan(step)
        if step not in self.references:
            emulator, device = self.emulator(*QUIET_BENCH)
            self.must("scan", "plan.toml", "-o", "tcp.h5", "--device", device)
            emulator.send_signal(signal.SIGINT)
            emulator.wait(timeout=20)
            kept = pathlib.Path(os.environ.get("TMPDIR", "/tmp")) / f"reference-{step}.h5"
            shutil.copy(self.folder / "tcp.h5", kept)
            self.references[step] = kept
        return self.references[step]

    def fault(self):
        """Name of the latched fault, and whether the interlock is open or closed."""
        info = self.must("device", "info", "--device", "usb").stdout
        return info.split("fault ")[1].split(",")[0], info.split("interlock ")[1].split()[0]

    def wait_for_records(self, process, bytes_at_least, seconds=60):
        def grown():
            self.assertIsNone(process.poll(), "the scan ended before it could be disturbed")
            return any(path.stat().st_size > bytes_at_least for path in self.folder.glob("*.journal"))
        wait_until(grown, "the journal grows", seconds)

    def expect_same_records(self, file, reference, rows):
        """Every record once, equal to the reference in every bit but those of the time."""
        with h5py.File(file) as one, h5py.File(reference) as other:
            self.assertEqual(list(one["records/index"][:]), list(range(rows)))
            for column in other["records"]:
                if column != "time_s":
                    self.assertTrue(
                        numpy.array_equal(one["records"][column][:], other["records"][column][:]), column)
            self.assertTrue((numpy.diff(one["records/time_s"][:]) > 0).all(), "time goes on")
