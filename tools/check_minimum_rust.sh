#!/bin/sh
# Compiles library and command with the oldest Rust that Cargo.toml declares, as rustup has it; nothing is installed.
# Usage: check_minimum_rust.sh MINIMUM_RUST TARGET_FOLDER
set -u
minimum_rust=$1
target=$2

# refuse WHAT COMMAND: says what is missing and the line that mends it.
refuse() {
    printf 'make msrv: %s\n           type: %s\n' "$1" "$2" >&2
    exit 1
}

install="rustup toolchain install $minimum_rust --profile minimal"
command -v rustup >/dev/null 2>&1 ||
    refuse "rustup is missing; only rustup keeps several versions of Rust side by side" \
        "curl --proto =https --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y && $install"
# 1.89, or a release of it such as 1.89.1: never a newer minor version
pattern=$(printf '%s' "$minimum_rust" | sed 's/\./\\./g')
toolchain=$(rustup toolchain list | sed -n "s/^\($pattern\(\.[0-9]*\)\{0,1\}-[^ ]*\).*/\1/p" | head -n 1)
[ -n "$toolchain" ] || refuse "Rust $minimum_rust, the oldest that Cargo.toml declares, is not installed" "$install"

echo "compiling with $toolchain"
# `check` needs every language feature and library function that a build does
exec rustup run "$toolchain" cargo check --locked --workspace --exclude foldwing-import --lib --bins --target-dir "$target"
