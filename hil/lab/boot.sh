#!/usr/bin/env bash
# Boots Debian's stock kernel in QEMU with this machine's files read-only and runs a command there,
# as root, in this folder. Nothing of this machine is changed; only build/lab is written.
#
#   hil/lab/boot.sh [--timeout SECONDS] -- COMMAND…
#
# Exit code: the command's; 77 when there is no QEMU or no kernel to be had; 124 on timeout.
# Standard output and error of the command are printed when it writes them. In the lab /run is
# writable (TMPDIR and HOME lie there), and so is $UMOV_LAB_RESULTS, which is build/lab/results here.
set -euo pipefail
cd "$(dirname "$0")/../.."
here=hil/lab
work=$PWD/build/lab
timeout_s=900
if [[ ${1:-} == --timeout ]]; then timeout_s=$2; shift 2; fi
[[ ${1:-} == -- ]] && shift
(($# > 0)) || { sed -n '2,10p' "$0"; exit 2; }

skip() { printf 'the kernel lab is skipped: %s\n' "$*" >&2; exit 77; }

qemu=$(command -v qemu-system-x86_64) || skip "no qemu-system-x86_64 (apt install qemu-system-x86)"
busybox=$(command -v busybox) || skip "no busybox (apt install busybox-static)"
for tool in cpio gzip; do command -v "$tool" >/dev/null || skip "no $tool (apt install $tool)"; done
[[ $'\n'$("$busybox" --list)$'\n' == *$'\ninsmod\n'* ]] || skip "this busybox has no insmod (apt install busybox-static)"
[[ $(uname -m) == x86_64 ]] || skip "it needs an x86_64 machine"
mkdir -p "$work/results"

# The stock kernel: unpacked from Debian's package, which is not installed. A second run finds it.
kernel=$(find "$work" -maxdepth 4 -path '*/boot/vmlinuz-*' 2>/dev/null | sort -V | tail -n 1)
if [[ -z $kernel ]]; then
  package=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/^ *Depends: *//p' | head -n 1) || true
  [[ -n $package ]] || skip "apt knows no linux-image-amd64 (apt-get update?)"
  mkdir -p "$work/package"
  (cd "$work/package" && apt-get -qq -o APT::Sandbox::User=root download "$package" >/dev/null 2>&1) ||
    skip "the package $package can't be downloaded"
  rm -rf "$work/kernel" "$work/kernel.new"
  mkdir "$work/kernel.new"
  mapfile -t wanted < <(sed '/^#/d; s|.*|*/&.ko*|' "$here/modules.txt")
  dpkg-deb --fsys-tarfile "$work"/package/"$package"_*.deb |
    tar -x -C "$work/kernel.new" --wildcards '*/boot/vmlinuz-*' "${wanted[@]}" ||
    skip "the package $package can't be unpacked, or lacks a module of $here/modules.txt"
  rm -rf "$work/package"
  mv "$work/kernel.new" "$work/kernel"
  kernel=$(find "$work/kernel/boot" -name 'vmlinuz-*')
fi
modules=$(dirname "$(dirname "$kernel")")/lib/modules/${kernel##*/vmlinuz-}/kernel

# First file system: busybox, modules and init.
first=$(mktemp -d)
trap 'rm -rf "$first"' EXIT
mkdir -p "$first"/{bin,modules,proc,sys,dev,root}
cp "$busybox" "$first/bin/busybox"
cp "$here/init" "$first/init"
number=10
while read -r module; do
  [[ -z $module || $module == \#* ]] && continue
  file=$(find "$modules" -name "$module.ko*" -print -quit)
  [[ -n $file ]] || skip "the kernel has no module $module"
  cp "$file" "$first/modules/$number-${file##*/}"
  case $file in
    *.xz) unxz "$first/modules/$number-${file##*/}" ;;
    *.zst) unzstd -q --rm "$first/modules/$number-${file##*/}" ;;
  esac
  number=$((number + 1))
done < "$here/modules.txt"
(cd "$first" && find . | cpio --quiet -o -H newc | gzip -1) > "$work/initramfs.gz"

# What to run: quoted, so that spaces and quotes arrive as they are.
results=$work/results
rm -f "$results/exit-code"
{
  printf 'cd %q\n' "$PWD"
  printf 'export UMOV_LAB=1 UMOV_LAB_RESULTS=/run/results\n'
  [[ -n ${UMOV_BINARY:-} ]] && printf 'export UMOV_BINARY=%q\n' "$UMOV_BINARY"
  [[ -n ${UMOV_BOARD_IMAGE:-} ]] && printf 'export UMOV_BOARD_IMAGE=%q\n' "$UMOV_BOARD_IMAGE"
  printf '%q ' "$@"
  printf '\n'
} > "$results/command.sh"

code=0
timeout --foreground "$timeout_s" "$qemu" -accel tcg,thread=multi,tb-size=128 -cpu max -smp 2 -m 512 \
  -nodefaults -no-reboot -display none -serial stdio -monitor none \
  -kernel "$kernel" -initrd "$work/initramfs.gz" \
  -append "console=ttyS0 quiet loglevel=2 panic=-1 mitigations=off" \
  -virtfs local,path=/,mount_tag=root,security_model=none,readonly=on,multidevs=remap \
  -virtfs local,path="$results",mount_tag=results,security_model=none \
  < /dev/null || code=$?
((code == 124)) && { echo "the kernel lab was stopped after $timeout_s s" >&2; exit 124; }
[[ -s $results/exit-code ]] || { echo "the kernel in the lab did not come to an end (QEMU: $code)" >&2; exit 1; }
exit "$(< "$results/exit-code")"
