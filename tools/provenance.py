"""What a page says of where its numbers come from: program, commit, machine, load."""

import os
import pathlib
import platform
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[1]
UMOV = os.environ.get("UMOV_BINARY", str(SOURCE / "build/release/bin/umov"))


def commit():
    def git(*arguments):
        done = subprocess.run(["git", "-C", SOURCE, *arguments], text=True, capture_output=True, check=False)
        return done.stdout.strip()

    # Pages are what benchmarks and studies write: they change no number.
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs")
    return (git("rev-parse", "--short", "HEAD") or "unknown") + (" with changes" if changed else "")


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.machine()


def machine():
    return f"{os.cpu_count()} cores of {processor()}"


def busy():
    """The machine's load before the numbers are taken, which is what others take of it."""
    return f"load average {os.getloadavg()[0]:.1f} at the start"


def line(command):
    """The last line of a study's page."""
    return f"Written by `{command}`, commit {commit()}, {machine()}."


if __name__ == "__main__":
    print(line(sys.argv[1]))
