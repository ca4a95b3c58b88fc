#!/usr/bin/python3
"""Runs the safety matrix and writes what it measured into docs/safety.md, between its marks."""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import SOURCE, commit, machine  # noqa: E402

BEGIN, END = "<!-- measured -->\n", "<!-- end -->"
HEAD = "| on | trouble | fault | dark within, at most | measured while a record is taken |\n|---|---|---|---|---|\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", required=True, help="the page, which must have the marks")
    parser.add_argument("--build", default=str(SOURCE / "build/release"))
    arguments = parser.parse_args()
    page = pathlib.Path(arguments.output)
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END, 1)[1]
    with tempfile.TemporaryDirectory() as folder:
        rows = pathlib.Path(folder) / "rows"
        program = pathlib.Path(arguments.build) / "bin/test_mcu_board"
        subprocess.run([program, "--gtest_filter=SafetyMatrix/*"], check=True, stdout=subprocess.DEVNULL,
                       env=os.environ | {"UMOV_SAFETY_TABLE": str(rows)})
        table = rows.read_text(encoding="utf-8")
    origin = f"\nWritten by `./dev bench safety`, commit {commit()}, {machine()}.\n"
    page.write_text(before + BEGIN + HEAD + table + origin + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
