#!/usr/bin/env python3
"""Puts header and signature before a controller's program, and writes the key that a boot loader trusts.

  sign_image.py sign --key KEY --board NAME --version 0.1.0 --source-hash HEADER raw.bin
                     --binary OUT.bin --dfu OUT.dfu --header OUT
  sign_image.py trust --key KEY --header OUT.hpp

`raw.bin` begins with the 512 bytes left for the header (protocol/image_header.hpp). Signing is Ed25519
of RFC 8032 in whole numbers of Python: slow and open to timing, which a build does not mind; programs
sign with libsodium (umov device sign).
"""
import argparse
import hashlib
import pathlib
import re
import struct
import sys
import zlib

HEADER_BYTES = 512
SIGNED_HEADER_BYTES = 64
VENDOR_ID, UPDATE_PRODUCT_ID = 0x1209, 0x0002

P = 2**255 - 19
ORDER = 2**252 + 27742317777372353535851937790883648493
D = -121665 * pow(121666, P - 2, P) % P
ROOT = pow(2, (P - 1) // 4, P)


def even_x(y):
    """The even x of the point with this y."""
    square = (y * y - 1) * pow(D * y * y + 1, P - 2, P) % P
    x = pow(square, (P + 3) // 8, P)
    if (x * x - square) % P:
        x = x * ROOT % P
    return P - x if x & 1 else x


BASE_Y = 4 * pow(5, P - 2, P) % P
BASE = (even_x(BASE_Y), BASE_Y, 1, even_x(BASE_Y) * BASE_Y % P)


def plus(p, q):
    a, b = (p[1] - p[0]) * (q[1] - q[0]) % P, (p[1] + p[0]) * (q[1] + q[0]) % P
    c, d = 2 * p[3] * q[3] * D % P, 2 * p[2] * q[2] % P
    e, f, g, h = b - a, d - c, d + c, b + a
    return (e * f % P, g * h % P, f * g % P, e * h % P)


def times(scalar, point):
    result = (0, 1, 1, 0)
    while scalar:
        if scalar & 1:
            result = plus(result, point)
        point = plus(point, point)
        scalar >>= 1
    return result


def encoded(point):
    inverse = pow(point[2], P - 2, P)
    x, y = point[0] * inverse % P, point[1] * inverse % P
    return (y | (x & 1) << 255).to_bytes(32, "little")


def number(*parts):
    return int.from_bytes(hashlib.sha512(b"".join(parts)).digest(), "little")


def secret_of(seed):
    digest = hashlib.sha512(seed).digest()
    return (int.from_bytes(digest[:32], "little") & (1 << 254) - 8) | 1 << 254, digest[32:]


def public_key(seed):
    return encoded(times(secret_of(seed)[0], BASE))


def signature(seed, message):
    scalar, prefix = secret_of(seed)
    r = number(prefix, message) % ORDER
    point = encoded(times(r, BASE))
    s = (r + number(point, public_key(seed), message) * scalar) % ORDER
    return point + s.to_bytes(32, "little")


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def read_seed(path):
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        found = re.fullmatch(r"seed = ([0-9a-fA-F]{64})", line)
        if found:
            return bytes.fromhex(found[1])
    sys.exit(f"{path}: no line \"seed = \" with 64 hexadecimal digits")


def with_suffix(image):
    """DFU 1.1, appendix B."""
    file = image + struct.pack("<HHHH3sB", 0xFFFF, UPDATE_PRODUCT_ID, VENDOR_ID, 0x0100, b"UFD", 16)
    return file + struct.pack("<I", zlib.crc32(file) ^ 0xFFFFFFFF)


def sign(arguments):
    program = pathlib.Path(arguments.raw).read_bytes()[HEADER_BYTES:]
    if not program or len(program) % 4:
        sys.exit(f"{arguments.raw}: its program has {len(program)} bytes, no multiple of 4")
    parts = [int(part) for part in arguments.version.split(".")]
    version = parts[0] << 16 | parts[1] << 8 | parts[2]
    text = pathlib.Path(arguments.source_hash).read_text(encoding="utf-8")
    source_hash = int(re.search(r"0x[0-9a-fA-F]+", text)[0], 16)
    header = struct.pack("<8sII24sIIQI", b"UMOVFW01", HEADER_BYTES, len(program), arguments.board.encode(), version, 0,
                         source_hash, crc32c(program))
    header += struct.pack("<I", crc32c(header))
    assert len(header) == SIGNED_HEADER_BYTES
    header += signature(read_seed(arguments.key), header + program)
    header += b"\xff" * (HEADER_BYTES - len(header))
    pathlib.Path(arguments.header).write_bytes(header)
    pathlib.Path(arguments.binary).write_bytes(header + program)
    pathlib.Path(arguments.dfu).write_bytes(with_suffix(header + program))


def trust(arguments):
    key = ", ".join(f"0x{byte:02x}" for byte in public_key(read_seed(arguments.key)))
    development = pathlib.Path(__file__).resolve().parents[1] / "development.key"
    everybody_has_it = str(read_seed(arguments.key) == read_seed(development)).lower()
    pathlib.Path(arguments.header).write_text(f"""// The key that this boot loader trusts. Written by firmware/boot/tools/sign_image.py.
#pragma once

#include "firmware/boot/ed25519.hpp"

namespace umov::firmware::boot {{

inline constexpr PublicKey signing_key = {{{key}}};
inline constexpr bool development_key = {everybody_has_it};

}}  // namespace umov::firmware::boot
""", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    sub = commands.add_parser("sign")
    for name in ("--key", "--board", "--version", "--source-hash", "--binary", "--dfu", "--header"):
        sub.add_argument(name, required=True)
    sub.add_argument("raw")
    sub.set_defaults(run=sign)
    sub = commands.add_parser("trust")
    for name in ("--key", "--header"):
        sub.add_argument(name, required=True)
    sub.set_defaults(run=trust)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
