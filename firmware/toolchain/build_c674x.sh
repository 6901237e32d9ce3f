#!/bin/bash
# A C compiler for the TI C674x, made from the distribution's own source packages.
#
#   build_c674x.sh [FOLDER]     FOLDER: where it goes; default ${XDG_CACHE_HOME:-~/.cache}/hysgen/c674x
#
# Builds tic6x-elf binutils 2.40 and gcc 12.2 (C only, no library but libgcc): about five minutes on two cores.
# FOLDER appears whole at the end or not at all: the build happens in a scratch folder beside it, which goes away
# whatever happens. A second call finds the stamp of this recipe and returns at once.
# Environment: JOBS, parallel compilations (default: all processors); BINUTILS_TARBALL, GCC_TARBALL, other copies of
# the two archives (their digests are checked all the same: cycle budgets are measured with exactly this compiler).
set -euo pipefail
export LC_ALL=C

readonly BINUTILS_SHA256=797fbf86910eec8dec1e2815ab3e92b98b9cd8c9ab1a57b216cc97dd90b4df9f
readonly GCC_SHA256=50c63ff82919323c25fbbb4a9eae259edc974118a0fb30c905190cb782ec11c2
readonly BINUTILS_TARBALL=${BINUTILS_TARBALL:-/usr/src/binutils/binutils-2.40.tar.xz}
readonly GCC_TARBALL=${GCC_TARBALL:-/usr/src/gcc-12/gcc-12.2.0-dfsg.tar.xz}
readonly GFDL_PATCH=${GCC_TARBALL%/*}/debian/patches/gcc-gfdl-build.diff
readonly JOBS=${JOBS:-$(nproc)}

# Lines that each stage prints with these sources; they only pace the percentages.
readonly UNPACK_LINES=65228 BINUTILS_LINES=2610 GCC_LINES=4990

say() { printf 'c674x toolchain: %s\n' "$*"; }
fail() { say "$*" >&2; exit 1; }

recipe_digest() { sha256sum "$SCRIPT" | cut -d' ' -f1; }

require_packages() {
    local missing=()
    [[ -f $BINUTILS_TARBALL ]] || missing+=(binutils-source)
    [[ -f $GCC_TARBALL && -f $GFDL_PATCH ]] || missing+=(gcc-12-source)
    local tool header
    for tool in gcc g++ make patch flex bison xz; do
        command -v "$tool" >/dev/null || missing+=("${tool/xz/xz-utils}")
    done
    for header in gmp mpfr mpc; do
        echo "#include <$header.h>" | g++ -fsyntax-only -x c++ - 2>/dev/null || missing+=("lib$header-dev")
    done
    if ((${#missing[@]})); then
        fail "missing ${missing[*]}; get them with: apt-get install -y --no-install-recommends ${missing[*]}"
    fi
}

require_digest() {
    local archive=$1 expected=$2
    echo "$expected  $archive" | sha256sum --check --status ||
        fail "$archive: not the archive that this recipe was measured with (sha256 $expected)"
}

# stage NAME EXPECTED_LINES COMMAND...: runs the command and paces its output as percentages. The command has a process
# group of its own, so that an interruption ends all of it at once.
stage() {
    STAGE=$1
    say "$STAGE"
    set -m
    paced "$@" &
    JOB=$!
    set +m
    wait "$JOB"
    JOB=
}

paced() {
    "${@:3}" 2>&1 | tee "$WORK/log" | awk -v name="$1" -v expected="$2" '
        { percent = int(20 * NR / expected) * 5
          if (percent > shown && percent < 100) {
              shown = percent; printf "c674x toolchain: %s %d %%\n", name, percent; fflush() } }'
}

interrupt() {
    [[ -z $JOB ]] || kill -TERM -- "-$JOB" 2>/dev/null || true
    exit 130
}

clean_up() {
    local status=$?
    if ((status != 0 && status != 130)) && [[ -f $WORK/log ]]; then
        tail -n 25 "$WORK/log" >&2
        say "$STAGE failed; its last lines stand above" >&2
    fi
    rm -rf "$WORK"
}

unpack() {
    tar -xvf "$BINUTILS_TARBALL" -C "$WORK"
    # Half of gcc's files are tests and libraries of other languages.
    tar -xvf "$GCC_TARBALL" -C "$WORK" --exclude='*/gcc/testsuite/[!s]*' --exclude='*/libstdc++-v3' --exclude='*/libgo' \
        --exclude='*/libphobos' --exclude='*/libgomp' --exclude='*/libsanitizer'
    mv "$WORK"/binutils-* "$WORK/binutils"
    mv "$WORK"/gcc-* "$WORK/gcc"
    # Debian's archive comes without the manual that gcc's makefile wants to compare itself with.
    patch -p2 -d "$WORK/gcc" <"$GFDL_PATCH"
}

build_binutils() {
    mkdir "$WORK/binutils-build"
    cd "$WORK/binutils-build"
    ../binutils/configure --target=tic6x-elf --prefix="$PREFIX" --disable-nls --disable-werror --disable-multilib \
        --disable-gdb --disable-gdbserver --disable-sim --disable-gprof --disable-gprofng --disable-gold \
        --disable-plugins --disable-libdecnumber --disable-readline --disable-libctf --without-zstd
    make -j"$JOBS" MAKEINFO=true all-gas all-ld all-binutils
    make MAKEINFO=true DESTDIR="$ASIDE" install-strip-gas install-strip-ld install-strip-binutils
}

build_gcc() {
    mkdir "$WORK/gcc-build"
    cd "$WORK/gcc-build"
    PATH=$ASIDE$PREFIX/bin:$PATH
    ../gcc/configure --target=tic6x-elf --prefix="$PREFIX" --with-arch=c674x --enable-languages=c --enable-checking=no \
        --without-headers --with-newlib --disable-multilib --disable-bootstrap --disable-nls --disable-threads \
        --disable-shared --disable-hosted-libstdcxx --disable-libstdcxx --disable-libssp --disable-libquadmath \
        --disable-libatomic --disable-libgomp --disable-libsanitizer --disable-libvtv --disable-libcc1 --disable-gcov \
        --disable-lto --disable-plugin --disable-decimal-float --without-isl --without-zstd
    make -j"$JOBS" MAKEINFO=true all-gcc all-target-libgcc
    make MAKEINFO=true DESTDIR="$ASIDE" install-strip-gcc install-strip-target-libgcc
}

finish() {
    local share=$ASIDE$PREFIX/share/hysgen
    mkdir -p "$share"
    # What the assembler knows of every instruction: the simulator's latencies are held against it.
    cp "$WORK/binutils/include/opcode/tic6x-opcode-table.h" "$share/"
    recipe_digest >"$share/recipe.sha256"
    rm -rf "$ASIDE$PREFIX/share/"{info,man,locale}
    if [[ -e $PREFIX ]]; then mv -T "$PREFIX" "$WORK/replaced"; fi
    mv -T "$ASIDE$PREFIX" "$PREFIX"
}

SCRIPT=$(readlink -f "${BASH_SOURCE[0]}")
PREFIX=$(readlink -m "${1:-${XDG_CACHE_HOME:-$HOME/.cache}/hysgen/c674x}")
STAMP=$PREFIX/share/hysgen/recipe.sha256
if [[ -f $STAMP && $(<"$STAMP") == "$(recipe_digest)" ]]; then
    say "$PREFIX is up to date"
    exit 0
fi
if [[ -e $PREFIX && ! -f $STAMP && -n $(ls -A "$PREFIX") ]]; then
    fail "$PREFIX: not empty and not made by this script; name another folder"
fi

require_packages
require_digest "$BINUTILS_TARBALL" "$BINUTILS_SHA256"
require_digest "$GCC_TARBALL" "$GCC_SHA256"
mkdir -p "$(dirname "$PREFIX")"
WORK=$(mktemp -d "$PREFIX.building.XXXXXX")
ASIDE=$WORK/aside
JOB=
trap clean_up EXIT
trap interrupt INT TERM HUP

# The compiler's own speed matters less than the time to build it; what it emits does not depend on these flags.
export CFLAGS=-O0 CXXFLAGS=-O0
SECONDS=0
stage "1/3 unpacking" "$UNPACK_LINES" unpack
stage "2/3 binutils" "$BINUTILS_LINES" build_binutils
stage "3/3 gcc" "$GCC_LINES" build_gcc
finish
say "$PREFIX is ready after $SECONDS s"
