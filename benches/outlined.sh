#!/bin/sh
# Lists the functions of a release build that call vector intrinsics instead of containing them, with the number of such calls.
# Each is compiled without the CPU's features, often a closure or `array::map` inside a kernel. Only those that run every step matter.
# usage: benches/outlined.sh target/release/paid
set -eu
objdump --disassemble --demangle --no-show-raw-insn "$1" | awk '
    /^[0-9a-f]+ <.*>:$/ { caller = $0; sub(/^[0-9a-f]+ /, "", caller) }
    /call.*<core::core_arch::x86::/ { calls[caller]++ }
    END { for (caller in calls) print calls[caller], caller }' | grep 'paid_' | sort -rn
