"""Running the program as a user does: helpers shared by the integration tests."""

import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import time
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
UMOV = pathlib.Path(os.environ.get("UMOV_BINARY", SOURCE / "build/release/bin/umov"))


class UmovCase(unittest.TestCase):
    """A test with a temporary folder of its own, `self.folder`."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="umov-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def umov(self, *arguments, timeout=120):
        """Runs umov to its end; returns the completed process with text output."""
        return subprocess.run([UMOV, *map(str, arguments)], cwd=self.folder, text=True,
                              capture_output=True, timeout=timeout, check=False)

    def must(self, *arguments, timeout=120):
        """Runs umov and expects exit code 0."""
        done = self.umov(*arguments, timeout=timeout)
        self.assertEqual(done.returncode, 0, f"umov {arguments}: {done.stderr}")
        return done

    def refused(self, *arguments, says=(), code=1):
        """Runs umov and expects one message of one line with each text of `says` in it."""
        done = self.umov(*arguments)
        self.assertEqual(done.returncode, code, f"umov {arguments}: {done.stdout}{done.stderr}")
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        if code == 1:
            self.assertEqual(len(lines), 1, done.stderr)
        for text in says:
            self.assertIn(text, done.stderr)
        return done

    def start(self, *arguments):
        """Starts umov in the background; it is ended with the test."""
        process = subprocess.Popen([UMOV, *map(str, arguments)], cwd=self.folder, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(self.end, process)
        return process

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.kill()
        process.communicate()

    def emulator(self, *arguments):
        """Starts an emulator on a free port and returns (process, device string)."""
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        process = self.start("emulator", "--port", port, *arguments)
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline:
            self.assertIsNone(process.poll(), "the emulator ended at once")
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    return process, f"tcp:127.0.0.1:{port}"
            time.sleep(0.05)
        self.fail("the emulator does not listen")
        return None

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path
