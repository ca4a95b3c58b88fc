#!/usr/bin/env python3
"""Writes what board.toml says as a constexpr C++ header, or as the table of WIRING.md.

describe.py board.toml --header OUT.hpp
describe.py board.toml --wiring WIRING.md            rewrites the table between its marks
describe.py board.toml --wiring WIRING.md --check    exit 1 when the table is out of date

Refuses (exit 1, one line) a pin that is named twice, is no pin of the package, or can't do what it is
named for, and a ratio that gives no whole number of steps.
"""
import argparse
import re
import sys
import tomllib
from fractions import Fraction

AXES = ["incidence", "detector", "azimuth", "polarizer", "analyzer", "filter"]
# Alternate functions used (datasheet DS8626, table 9): pin -> (timer, channel).
STEP_TIMER = {
    "PA5": (2, 1), "PB3": (2, 2), "PB10": (2, 3), "PB11": (2, 4),
    "PA0": (5, 1), "PA1": (5, 2),
}
# Capture inputs of TIM1, alternate function 1: pin -> channel.
CAPTURE_CHANNEL = {"PA8": 1, "PE9": 1, "PA9": 2, "PE11": 2, "PA10": 3, "PE13": 3, "PA11": 4, "PE14": 4}
# ADC inputs (datasheet table 7).
ADC_CHANNEL = {f"PC{n}": 10 + n for n in range(6)} | {"PB0": 8, "PB1": 9} | {f"PA{n}": n for n in range(8)}
SAFETY = ["interlock", "emergency", "cool"]
OPTICS = ["laser_1", "laser_2", "laser_3", "shutter", "gain_0", "gain_1", "modulation", "reference", "signal",
          "monitor"]
AXIS_PINS = ["step", "direction", "home", "lower_limit", "upper_limit", "stall"]
MEANING = {
    "tx": ("out", "USART2 TX, 3.3 V"), "rx": ("in", "USART2 RX, 3.3 V"),
    "laser_1": ("out", "532 nm enable, high = on"), "laser_2": ("out", "633 nm enable, high = on"),
    "laser_3": ("out", "814 nm enable, high = on"), "shutter": ("out", "high = open"),
    "gain_0": ("out", "amplifier range, bit 0"), "gain_1": ("out", "amplifier range, bit 1"),
    "modulation": ("out", "reference: gates the enabled laser, high = light"),
    "reference": ("in, pulled down", "external reference, rising edge where the light comes on"),
    "signal": ("analog", "photodiode amplifier, 0 to VDD and never above, rests at VDD/2"),
    "monitor": ("analog", "monitor amplifier, 0 to VDD and never above, rests at VDD/2"),
    "interlock": ("in, pulled down", "high = closed; a broken wire is an open interlock"),
    "emergency": ("in, pulled down", "high = emergency button out; a broken wire is a pressed one"),
    "cool": ("in, pulled down", "high = thermostats closed; a broken wire is too hot"),
    "jtdi": ("debug", "pulled up at reset; left alone"),
    "usb_dm": ("USB", "D-, connector CN5"), "usb_dp": ("USB", "D+, connector CN5"),
    "usb_vbus": ("in", "not looked at; wired to CN5"),
    "swdio": ("debug", "ST-LINK"), "swclk": ("debug", "ST-LINK"),
    "step": ("out", "step, rising edge, {pulse} µs"), "direction": ("out", "high = positive sense"),
    "home": ("in, pulled up", "home switch, normally closed to ground"),
    "lower_limit": ("in, pulled up", "lower limit, normally closed to ground"),
    "upper_limit": ("in, pulled up", "upper limit, normally closed to ground"),
    "stall": ("in, pulled down", "driver reports lost steps, rising edge"),
}


# stop_delay_us of firmware/core/config/design_parameters.hpp.
STOP_DELAY_S = 0.002


class Refused(Exception):
    pass


def pins_of(board):
    """All (owner, role, pin), in the order of the table."""
    found = [("link", role, board["link"][role]) for role in ("tx", "rx")]
    found += [("optics", role, board["optics"][role]) for role in OPTICS]
    found += [("safety", role, board["safety"][role]) for role in SAFETY]
    for axis in board["axis"]:
        found += [(axis["name"], role, axis[role]) for role in AXIS_PINS]
    found += [("usb", role, pin) for role, pin in board["usb"].items()]
    return found + [("reserved", role, pin) for role, pin in board["reserved"].items()]


def check(board):
    seen = {}
    for owner, role, pin in pins_of(board):
        if not re.fullmatch(r"P[A-E](\d|1[0-5])", pin):
            raise Refused(f"{owner}.{role}: {pin} is no pin of the package")
        if pin in seen:
            raise Refused(f"{owner}.{role}: {pin} is already {seen[pin]}")
        seen[pin] = f"{owner}.{role}"
    if [axis["name"] for axis in board["axis"]] != AXES:
        raise Refused("axes must be " + ", ".join(AXES))
    stalls = {}
    for axis in board["axis"]:
        if axis["step"] not in STEP_TIMER:
            raise Refused(f"{axis['name']}.step: {axis['step']} is no output of TIM2 or TIM5")
        line = int(axis["stall"][2:])
        if line in stalls or line < 4 or line > 9:
            raise Refused(f"{axis['name']}.stall: needs an EXTI line 4 to 9 of its own")
        stalls[line] = axis["name"]
        room, needed = Fraction(str(axis["overrun_deg"])), stopping_deg(axis)
        if needed > room:
            raise Refused(f"{axis['name']}.overrun_deg: {float(room):g} degrees beyond a limit switch, but it needs "
                          f"{needed:.2f} to stop from {axis['speed_deg_s']} degrees/s")
    lines = {}
    for role in SAFETY:
        line = int(board["safety"][role][2:])
        if line in lines or line < 10:
            raise Refused(f"safety.{role}: needs an EXTI line 10 to 15 of its own")
        lines[line] = role
    if board["optics"]["reference"] not in CAPTURE_CHANNEL:
        raise Refused(f"optics.reference: {board['optics']['reference']} is no input of TIM1")
    for role in ("signal", "monitor"):
        if board["optics"][role] not in ADC_CHANNEL:
            raise Refused(f"optics.{role}: {board['optics'][role]} is no input of ADC1 and ADC2")


def steps_per_turn(axis):
    steps = axis["motor_steps"] * axis["microsteps"] * Fraction(str(axis["gear"]))
    if steps.denominator != 1:
        raise Refused(f"{axis['name']}: {float(steps)} steps a turn are not whole")
    return int(steps)


def stopping_deg(axis):
    """Way beyond a limit switch, as firmware/core/motion/stopping_distance.hpp has it (a test compares the two)."""
    v, a, j = (float(axis[key]) for key in ("speed_deg_s", "acceleration_deg_s2", "jerk_deg_s3"))
    if v * j >= a * a:
        way = a / j * (v - a * a / (6 * j)) + v * v / (2 * a) + v * a / (2 * j)
    else:
        way = 11 / 6 * v * (v / j) ** 0.5
    return way + v * STOP_DELAY_S + 360 / steps_per_turn(axis)


def pin_text(pin):
    return f"{{Port::{pin[1]}, {pin[2:]}}}"


def scaled(axis, key, factor):
    value = Fraction(str(axis.get(key, 0))) * factor
    if value.denominator != 1:
        raise Refused(f"{axis['name']}.{key}: finer than the controller's unit")
    return f"{int(value)}"


def header(board):
    out = ["// Written by boards/stm32f407/tools/describe.py from board.toml; do not edit.", "#pragma once", "",
           "#include <array>", "#include <cstdint>", "",
           '#include "boards/stm32f407/description.hpp"', '#include "firmware/core/config/axis_settings.hpp"', "",
           "namespace umov::boards::stm32f407 {", ""]
    b, link, optics = board["board"], board["link"], board["optics"]
    out += [f'inline constexpr char board_name[] = "{b["name"]}";',
            f"inline constexpr std::uint32_t crystal_hz = {b['crystal_hz']};",
            f"inline constexpr std::uint32_t core_hz = {b['core_hz']};",
            f"inline constexpr std::uint32_t step_pulse_us = {b['step_pulse_us']};",
            f"inline constexpr std::uint32_t step_low_us = {b['step_low_us']};",
            f"inline constexpr std::uint32_t link_baud = {link['baud']};",
            f"inline constexpr Pin link_tx{pin_text(link['tx'])};",
            f"inline constexpr Pin link_rx{pin_text(link['rx'])};"]
    lasers = ", ".join(pin_text(optics[f"laser_{n}"]) for n in (1, 2, 3))
    out.append(f"inline constexpr std::array<Pin, 3> laser_pins = {{{{{lasers}}}}};")
    gains = ", ".join(pin_text(optics[f"gain_{n}"]) for n in (0, 1))
    out.append(f"inline constexpr std::array<Pin, 2> gain_pins = {{{{{gains}}}}};")
    for role in ("shutter", "modulation"):
        out.append(f"inline constexpr Pin {role}_pin{pin_text(optics[role])};")
    for role in ("signal", "monitor"):
        out.append(f"inline constexpr AnalogInput {role}_input{{{pin_text(optics[role])}, "
                   f"{ADC_CHANNEL[optics[role]]}}};")
    out.append(f"inline constexpr CaptureInput reference_input{{{pin_text(optics['reference'])}, "
               f"{CAPTURE_CHANNEL[optics['reference']]}}};")
    for role in ("usb_dm", "usb_dp"):
        out.append(f"inline constexpr Pin {role}_pin{pin_text(board['usb'][role])};")
    for role in SAFETY:
        out.append(f"inline constexpr Pin {role}_pin{pin_text(board['safety'][role])};")
    out += ["",
            "inline constexpr std::array<AxisPins, 6> axis_pins = {{"]
    for axis in board["axis"]:
        timer, channel = STEP_TIMER[axis["step"]]
        pins = ", ".join(f".{role} = {pin_text(axis[role])}" for role in AXIS_PINS)
        out.append(f"    {{{pins}, .timer = {timer}, .channel = {channel}}},  // {axis['name']}")
    out += ["}};", "", "inline constexpr std::array<firmware::AxisSettings, 6> axes = {{"]
    for axis in board["axis"]:
        fields = [("steps_per_turn", str(steps_per_turn(axis))),
                  ("min_udeg", scaled(axis, "min_deg", 10**6)), ("max_udeg", scaled(axis, "max_deg", 10**6)),
                  ("speed_mdeg_s", scaled(axis, "speed_deg_s", 1000)),
                  ("acceleration_mdeg_s2", scaled(axis, "acceleration_deg_s2", 1000)),
                  ("jerk_mdeg_s3", scaled(axis, "jerk_deg_s3", 1000)),
                  ("take_up_udeg", scaled(axis, "take_up_deg", 10**6)),
                  ("open_udeg", scaled(axis, "open_deg", 10**6)),
                  ("homing_mdeg_s", scaled(axis, "homing_deg_s", 1000)),
                  ("approach_mdeg_s", scaled(axis, "approach_deg_s", 1000))]
        out.append("    {" + ", ".join(f".{name} = {value}" for name, value in fields) + "},")
    out += ["}};", "", "}  // namespace umov::boards::stm32f407", ""]
    return "\n".join(out)


def wiring_table(board):
    rows = ["| pin | of | signal | kind | meaning |", "|---|---|---|---|---|"]
    for owner, role, pin in pins_of(board):
        kind, meaning = MEANING[role]
        rows.append(f"| {pin} | {owner} | `{role}` | {kind} | "
                    f"{meaning.format(pulse=board['board']['step_pulse_us'])} |")
    rows += ["", "| axis | steps/turn | limits | speed | acceleration | jerk | stops beyond a limit switch within | room there |",
             "|---|---|---|---|---|---|---|---|"]
    for axis in board["axis"]:
        rows.append(f"| {axis['name']} | {steps_per_turn(axis)} = {axis['motor_steps']} × {axis['microsteps']} × "
                    f"{axis['gear']} | {axis['min_deg']}° to {axis['max_deg']}° | {axis['speed_deg_s']} °/s | "
                    f"{axis['acceleration_deg_s2']} °/s² | {axis['jerk_deg_s3']} °/s³ | {stopping_deg(axis):.2f}° | "
                    f"{axis['overrun_deg']}° |")
    return "\n".join(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("board")
    parser.add_argument("--header")
    parser.add_argument("--wiring")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    with open(arguments.board, "rb") as file:
        board = tomllib.load(file)
    try:
        check(board)
        text = header(board)
        if arguments.header:
            with open(arguments.header, "w", encoding="utf-8") as file:
                file.write(text)
        if arguments.wiring:
            with open(arguments.wiring, encoding="utf-8") as file:
                page = file.read()
            begin, end = "<!-- board.toml -->\n", "<!-- end -->"
            before, rest = page.split(begin)
            after = rest.split(end, 1)[1]
            fresh = before + begin + wiring_table(board) + "\n" + end + after
            if fresh != page:
                if arguments.check:
                    raise Refused(f"{arguments.wiring} is out of date: run this without --check")
                with open(arguments.wiring, "w", encoding="utf-8") as file:
                    file.write(fresh)
    except (Refused, KeyError) as error:
        print(f"{arguments.board}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
