#!/usr/bin/python3
"""What the controller's program costs on the emulated STM32F407, in instructions.

Virtual time and instructions do not depend on the machine; only the last line, the speed of the emulation, does.
"""

import argparse
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import SOURCE, busy, commit, machine  # noqa: E402

PAGE = """# The controller, measured on the emulated board

The image that is flashed runs on the emulated STM32F407 (`hil/mcu`). Command `./dev bench controller{options}`, commit {commit},
{machine}, {load}.
{complaints}
**Instructions, not cycles**: the emulation counts each instruction as one cycle of 168 MHz and adds 24 for an interrupt's
entry and return. Flash wait states, pipeline refills and instructions of several cycles are not in these figures; the
real chip takes more. The bounds of the project are in the same unit: lock-in on two channels at 100 kS/s at most 30 %,
200,000 steps/s on one axis and 100,000 on three at once.

{figures}

The shares of motion are those during the fastest part of a move. Edges: on their tick of 0.25 µs, within one, for one axis
at 200,000 steps/s and three at 100,000; with six axes at full speed some edges come up to 2 µs late, because one interrupt
serves six axes in turn. None is lost (`test_mcu_board --gtest_filter='StepEdges.*'`).

## Long runs

{limits}

The stopping distance is what a stop at the end of the acceleration takes: the rest of the way to full speed, (a/j)(v - a²/6j), the
ramp, v²/2a + va/2j (both less where a or v is not reached), and 2 ms of the speed, as a limit switch is found in a step's interrupt and the stop planned in the next tick (`firmware/core/motion/stopping_distance.hpp`). Phase bias of the native core over 1,000 records at 1013.7, 777.777 and 3141.592 Hz: `test_firmware
--gtest_filter='*NoPhaseBias*'` prints it (below 3e-7 rad) and holds it below 1e-6 rad.

## External reference

Edges at the reference input, and light whose phase is known, detected against them: periods from the first edge to the lock,
and the phase of records against that of the light, rms, of records shorter than the loop remembers (eight periods, at least
5 ms). Both as the controller tells them over its protocol; asking takes the flashed image a millisecond or two, so the lock
is shown where a period is longer. The bounds of the project: 20 periods, 1e-4 rad.

{reference}

A frequency that swings by 1e-5 in 10 s is that of a chopper held by its own quartz; jitter is that of the edges alone, each on
its own, and 0.29 of it reaches a phase (0.47 at low frequencies; `test_firmware --gtest_filter='ReferenceLock*'`). So 1e-4 rad
need edges steadier than 0.02°: at 0.2° the bound is missed, by the edges and not by the loop.

{size}
"""


def measure(complaints, program, *arguments):
    """What the program prints, also where it ends with 1: what it complains of is noted, and left for the page."""
    done = subprocess.run([program, *arguments], check=False, text=True, capture_output=True)
    print(done.stderr, end="", file=sys.stderr)
    if done.returncode not in (0, 1) or not done.stdout:
        raise SystemExit(f"{program.name} ended with {done.returncode}; no page is written")
    if done.returncode == 1:
        complaints += dict.fromkeys(done.stderr.splitlines() or [f"{program.name} ended with 1"])
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--steps", default="1e7", help="steps of the long run on the emulated chip")
    parser.add_argument("--build", default=str(SOURCE / "build/release"))
    arguments = parser.parse_args()
    build = pathlib.Path(arguments.build)
    load = busy()
    image = build / "firmware/bin/umov-stm32f407.elf"
    complaints = []
    figures = measure(complaints, build / "bin/bench_mcu", image)
    limits = measure(complaints, build / "bin/bench_controller_limits", image, arguments.steps)
    reference = measure(complaints, build / "bin/bench_reference")
    check = SOURCE / "boards/stm32f407/tools/check_image.py"
    size = subprocess.run([sys.executable, check, "--nm", "arm-none-eabi-nm", "--elf", image, "--binary",
                           image.with_suffix(".bin"), "--objects", build / "firmware/firmware",
                           build / "firmware/boards/stm32f407/CMakeFiles/umov-stm32f407.dir"], check=True, text=True,
                          capture_output=True).stdout
    pathlib.Path(arguments.output).write_text(
        PAGE.format(options="" if arguments.steps == "1e7" else f" --steps {arguments.steps}", commit=commit(),
                    machine=machine(), load=load,
                    complaints="".join(f"\n**Not met** – {line}\n" for line in complaints),
                    figures=figures.strip(), limits=limits.strip(), reference=reference.strip(), size=size.strip()),
        encoding="utf-8")
    if complaints:
        print(f"{arguments.output} is written; what is not met stands at its top", file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
