#!/usr/bin/env python3
"""Prints what the image takes and fails when it is over its budget: flash, static RAM, and the
deepest stack of main and of one interrupt of each priority on top of another.

The stack comes from the compiler's call graph (-fcallgraph-info=su). What a call through a pointer
may reach is declared in POINTERS; one that is not declared, recursion and frames of unbounded size are
refused.
"""
import argparse
import pathlib
import re
import subprocess
import sys

# Flash and RAM of the program, and of the boot loader (sectors 0 and 1).
BUDGETS = {False: (96 * 1024, 64 * 1024), True: (32 * 1024, 16 * 1024)}
# Routines of the compiler's and the C library have no entry in the call graph; none of those linked
# (memcpy, memset, memmove, 64-bit division) takes more.
LIBRARY_FRAME = 64
# Eight words pushed by the processor, and one to align.
EXCEPTION_FRAME = 36
# Handlers by priority; interrupts of one priority do not interrupt each other (main.cpp).
HANDLERS = [
    ["tim2_handler", "tim5_handler"],
    ["exti4_handler", "exti9_5_handler", "exti15_10_handler", "pvd_handler", "adc_handler"],
    ["dma2_stream0_handler"],
    ["dma1_stream6_handler", "otg_fs_handler", "systick_handler"],
]
PORT = r"UsbPort::(connect|disconnect|set_address|open_endpoint|close_endpoint|send|receive|stall|clear_stall)\("
APPLICATION = r"UsbApplication::"
BOOT_FLASH = r"stm32f407::BootFlash::"
SERIAL = r"stm32f407::UartLink::(room|write)\("
# Who calls through a pointer or a virtual function, and what: the interfaces of firmware/core and what
# this board makes of them. The first that fits the caller counts.
POINTERS = [
    (r"usb::LinkSwitch::room\(", SERIAL),
    (r"usb::LinkSwitch::(write|send|start|stop|on_sent|on_halt_cleared|answer)[<(]|usb::LinkPipe::",
     f"{PORT}|{SERIAL}"),
    (r"usb::(Device|LinkSwitch)::", f"{PORT}|{APPLICATION}|{SERIAL}"),
    (r"usb::ControlPipe::", f"{PORT}|non-virtual thunk to .*usb::Device::on_(request|data|complete)"),
    (r"stm32f407::UsbPort::", r"^umov::firmware::usb::Device::on_(reset|suspend|resume|setup|sent|received)\("),
    (r"firmware::SettingsPages::", r"stm32f407::SettingsFlash::"),
    (r"firmware::boot::", BOOT_FLASH),
    (r"^umov::firmware::|^(void|bool) umov::firmware::",
     r"stm32f407::(Stm32Board|FlashLog)::|firmware::SettingsPages::(load|save|next_save_is_slow)"),
    (r"^main$", PORT),
    (r"^reset_handler$", r"_GLOBAL__sub_I|static_initialization"),
]
FORBIDDEN = ["malloc", "calloc", "realloc", "free", "_Znwj", "_Znaj", "_ZdlPv", "_ZdlPvj", "_sbrk",
             "__cxa_throw", "__cxa_allocate_exception", "_Unwind_Resume", "__cxa_guard_acquire"]
# Arithmetic in floating point, and conversions to it and from it.
FLOATING_POINT = re.compile(r"__aeabi_([fd]|c[fd]|u?[il]2[fd])")


# The same of the boot loader, which uses no interrupts.
BOOT_POINTERS = [
    (r"usb::ControlPipe::", f"{PORT}|non-virtual thunk to .*boot::BootDevice::on_(request|data|complete)"),
    (r"boot::BootDevice::", PORT),
    (r"firmware::boot::", BOOT_FLASH),
    (r"stm32f407::UsbPort::", r"^umov::firmware::boot::BootDevice::on_(reset|suspend|resume|setup|sent|received)\("),
    (r"^main$", f"{PORT}|{BOOT_FLASH}"),
    (r"^reset_handler$", r"_GLOBAL__sub_I|static_initialization"),
]


def fail(text):
    print(f"umov-stm32f407: {text}", file=sys.stderr)
    sys.exit(1)


def symbols(nm, elf):
    listing = subprocess.run([nm, elf], check=True, capture_output=True, text=True).stdout
    return {parts[2]: int(parts[0], 16) for parts in (line.split() for line in listing.splitlines())
            if len(parts) == 3}


def demangled(nm, names):
    """Readable names; c++filt lies beside nm."""
    filter_program = str(nm)[:-2] + "c++filt"
    text = subprocess.run([filter_program], input="\n".join(names), check=True, capture_output=True, text=True).stdout
    return dict(zip(names, text.splitlines()))


def call_graph(folders, linked):
    """Frames and calls of the functions that are in the image."""
    frames, calls = {}, {}
    for path in (path for folder in folders for path in pathlib.Path(folder).rglob("*.ci")):
        text = path.read_text(encoding="utf-8")
        for title, label in re.findall(r'node: \{ title: "([^"]*)" label: "([^"]*)"', text):
            size = re.search(r"\\n(\d+) bytes \((\w+)", label)
            name = title.rsplit(":", 1)[-1]
            if not size or name not in linked:
                continue
            if size[2] == "dynamic" and "bounded" not in label:
                fail(f"{name} has a frame of unbounded size")
            frames[name] = max(frames.get(name, 0), int(size[1]))
        for source, target in re.findall(r'edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"', text):
            calls.setdefault(source.rsplit(":", 1)[-1], set()).add(target.rsplit(":", 1)[-1])
    return frames, calls


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("--nm", "--elf", "--binary"):
        parser.add_argument(name, required=True)
    parser.add_argument("--objects", required=True, nargs="+", help="folders with what it is made of")
    parser.add_argument("--boot", action="store_true", help="the boot loader")
    arguments = parser.parse_args()
    handlers = [] if arguments.boot else HANDLERS
    pointers = BOOT_POINTERS if arguments.boot else POINTERS
    flash_budget, ram_budget = BUDGETS[arguments.boot]
    linked = symbols(arguments.nm, arguments.elf)
    for name in linked:
        if name in FORBIDDEN or FLOATING_POINT.match(name):
            fail(f"refers to {name}: no heap, exceptions or floating point")

    frames, calls = call_graph(arguments.objects, linked)
    entries = {"main", "reset_handler", "fault_handler"} | {h for group in handlers for h in group}
    for name in entries - {"fault_handler"}:
        if name not in frames:
            fail(f"{name} is not in the call graph")
    plain = demangled(arguments.nm, sorted(frames))
    deepest = {}

    def reached_from(caller):
        for pattern, targets in pointers:
            if re.search(pattern, plain[caller]):
                return [name for name in frames if re.search(targets, plain[name])]
        fail(f"{plain[caller]} calls through a pointer: declare what that may reach in POINTERS")

    def depth(name, path):
        if name == "__indirect_call":
            return max((depth(target, path) for target in reached_from(path[-1])), default=0)
        if name in path:
            fail("recursion: " + " -> ".join(plain[n] for n in path + [name]))
        if name not in frames:
            return LIBRARY_FRAME
        if name not in deepest:
            below = max((depth(target, path + [name]) for target in calls.get(name, ())), default=0)
            deepest[name] = frames[name] + below
        return deepest[name]

    parts = [depth("reset_handler", [])]
    parts += [EXCEPTION_FRAME + max(depth(handler, []) for handler in group) for group in handlers]
    stack = sum(parts)
    stack_size = linked["image_stack_top"] - linked["image_stack_begin"]
    flash = pathlib.Path(arguments.binary).stat().st_size
    ram = linked["image_bss_end"] - linked["image_stack_begin"]
    print(f"{pathlib.Path(arguments.elf).stem}: flash {flash} of {flash_budget} B, RAM {ram} of {ram_budget} B with "
          f"{stack_size} B of stack, of which at most {stack} are used "
          f"(main {parts[0]}, interrupts {', '.join(str(p) for p in parts[1:]) or 'none'})")
    if flash > flash_budget or ram > ram_budget:
        fail("over its budget")
    if stack > stack_size:
        fail("the stack may run over its end")


if __name__ == "__main__":
    main()
