#!/bin/sh
# Checks that what `make` needs is there and new enough; prints the one line to type for what is not.
# Usage: check_toolchain.sh MINIMUM_RUST MINIMUM_PYTHON [MAKE_VERSION]
set -u
minimum_rust=$1
minimum_python=$2
make_version=${3:-}
python=${PYTHON:-python3}
missing=0

# at_least HAVE WANT: whether version HAVE is WANT or newer, number by number.
at_least() {
    printf '%s %s\n' "$1" "$2" | awk '{
        n = split($2, want, "."); split($1, have, ".")
        for (i = 1; i <= n; i++) {
            if (have[i] + 0 > want[i] + 0) exit 0
            if (have[i] + 0 < want[i] + 0) exit 1
        }
        exit 0
    }'
}

# complain WHAT COMMAND: says what is wrong and the line that mends it.
complain() {
    printf 'make: %s\n      type: %s\n' "$1" "$2" >&2
    missing=1
}

# How this system installs the packages that follow as "apt dnf pacman brew" names.
install_line() {
    if command -v apt-get >/dev/null 2>&1; then echo "sudo apt-get install -y $1"
    elif command -v dnf >/dev/null 2>&1; then echo "sudo dnf install -y $2"
    elif command -v pacman >/dev/null 2>&1; then echo "sudo pacman -S --needed $3"
    elif command -v brew >/dev/null 2>&1; then echo "brew install $4"
    else echo "install $1 with your system's package manager"
    fi
}

# shellcheck disable=SC2016 # the line is for the user's shell
rustup='curl --proto =https --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y && . "$HOME/.cargo/env"'

if ! command -v cargo >/dev/null 2>&1 || ! command -v rustc >/dev/null 2>&1; then
    complain "cargo (Rust $minimum_rust or newer) is missing" "$rustup"
else
    rust=$(rustc --version 2>/dev/null | awk '{ sub(/-.*/, "", $2); print $2 }')
    if ! at_least "${rust:-0}" "$minimum_rust"; then
        if command -v rustup >/dev/null 2>&1; then rustup='rustup update stable'; fi
        complain "Rust ${rust:-of unknown version} is too old; $minimum_rust or newer is needed" "$rustup"
    fi
fi

if ! command -v "${CC:-cc}" >/dev/null 2>&1; then
    complain "a C compiler (${CC:-cc}) is missing; Rust links with it" \
        "$(install_line build-essential gcc base-devel gcc)"
fi

if ! command -v "$python" >/dev/null 2>&1; then
    complain "$python ($minimum_python or newer) is missing" \
        "$(install_line 'python3 python3-venv' python3 python python)"
else
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
    if ! at_least "${version:-0}" "$minimum_python"; then
        complain "$python is Python ${version:-of unknown version}; $minimum_python or newer is needed" \
            "$(install_line 'python3 python3-venv' python3 python python)"
    fi
fi

if [ -n "$make_version" ] && ! at_least "$make_version" 3.81; then
    complain "GNU make $make_version is too old; 3.81 or newer is needed" "$(install_line make make make make)"
fi

exit "$missing"
