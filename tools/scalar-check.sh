#!/usr/bin/env bash
# Shows that `--lanes 1` is scalar: the width-1 instances of the kernel hold no packed float arithmetic.
#
#   tools/scalar-check.sh [BINARY]
#
# Builds the release binary with readable symbol names in a target folder of its own (or takes one built so), and counts
# scalar (…ss) and packed (…ps, …pd) float arithmetic: add, sub, mul, div, sqrt, min, max and fused multiply-add. Moves,
# shuffles, blends and bitwise operations are not arithmetic. Exit code 1 if any width-1 function holds a packed one.
# Needs objdump (Debian: binutils).
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v objdump >/dev/null; then
    echo "scalar-check: objdump is missing; install binutils" >&2
    exit 2
fi

binary=${1:-}
if [[ -z $binary ]]; then
    # The flags of .cargo/config.toml, which RUSTFLAGS would otherwise replace.
    flags=$(sed -n 's/^rustflags *= *\[\(.*\)\].*/\1/p' .cargo/config.toml | tr -d '",')
    RUSTFLAGS="$flags -C symbol-mangling-version=v0" cargo build --release --bin octolux --target-dir target/scalar-check
    binary=target/scalar-check/release/octolux
fi

objdump -d --no-show-raw-insn --demangle=rust "$binary" | awk '
    # A function of the kernel, by the lane type it is instantiated for; "" for everything else.
    function width(name) {
        # A path of a room of the kernel with the lane type as its first argument, or an operation of the lanes themselves.
        if (name !~ /octolux::(kernel|accel|geometry|bsdf|light|sampling|lane|report)::?[A-Za-z0-9_:>]*<[A-Za-z0-9_:]*f32(x8|x16)?[>,]/ \
            && name !~ /<[A-Za-z0-9_:]*f32(x8|x16)? as octolux::lane::/) return ""
        if (name ~ /f32x16/) return "16"
        if (name ~ /f32x8/) return "8"
        return "1"
    }
    /^[0-9a-f]+ <.*>:$/ {
        name = $0
        sub(/^[0-9a-f]+ </, "", name)
        sub(/>:$/, "", name)
        w = width(name)
        if (w != "") { functions[w]++; names[w, functions[w]] = name; label = w SUBSEP functions[w] }
        next
    }
    w == "" { next }
    {
        op = $2
        if (op ~ /^v?(add|sub|mul|div|sqrt|min|max|fn?m(add|sub)(132|213|231))s[sd]$/) { scalar[label]++; all_scalar[w]++ }
        if (op ~ /^v?(add|sub|mul|div|sqrt|min|max|addsub|hadd|hsub|dp|fn?m(add|sub|addsub|subadd)(132|213|231))p[sd]$/) {
            packed[label]++; all_packed[w]++
            if (w == "1" && shown[label]++ < 5) example[label] = example[label] "\n        " $0
        }
    }
    END {
        printf "%-6s %9s %14s %14s\n", "lanes", "functions", "scalar float", "packed float"
        for (i = 1; i <= 3; i++) {
            v = i == 1 ? "1" : i == 2 ? "8" : "16"
            printf "%-6s %9d %14d %14d\n", v, functions[v], all_scalar[v], all_packed[v]
        }
        print "\nwidth 1, by function (scalar, packed):"
        for (i = 1; i <= functions["1"]; i++) {
            label = "1" SUBSEP i
            if (scalar[label] + packed[label] == 0) continue
            printf "%6d %6d  %s%s\n", scalar[label], packed[label], names["1", i], example[label]
        }
        if (functions["1"] == 0 || functions["8"] == 0 || all_scalar["1"] == 0 || all_packed["8"] == 0) {
            print "scalar-check: found no kernel to look at: were symbols stripped, or names mangled the old way?"
            exit 2
        }
        if (all_packed["1"] > 0) { print "\nscalar-check: FAILED, width 1 holds packed float arithmetic"; exit 1 }
        print "\nscalar-check: width 1 is scalar"
    }'
