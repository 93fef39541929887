#!/usr/bin/env bash
# feeds one reader with inputs that libFuzzer makes of tests/fuzz/corpus/TARGET, for some seconds, under the address and
# undefined-behaviour sanitizers. What it finds stays in build/fuzz/found; put it, made small, into the corpus with its repair.
# usage: scripts/fuzz.sh TARGET SECONDS [libFuzzer option...]    needs clang-14 and libclang-rt-14-dev
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
(($# >= 2)) || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
target="$1" seconds="$2"

command -v clang++-14 > /dev/null || { echo "fuzz: clang is missing; run scripts/setup.sh --cluster" >&2; exit 4; }
launcher=()
command -v ccache > /dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
cmake -S tests/fuzz -B build/fuzz -G Ninja --log-level=WARNING -DCMAKE_C_COMPILER=clang-14 -DCMAKE_CXX_COMPILER=clang++-14 "${launcher[@]}"
cmake --build build/fuzz --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}"

mkdir -p "build/fuzz/corpus/$target" build/fuzz/found
# most readers read a file, which is written anew for each execution; on a disk that takes most of the time
[[ -n ${TMPDIR:-} || ! -w /dev/shm ]] || export TMPDIR=/dev/shm
dictionary=()
[[ -f tests/fuzz/$target.dict ]] && dictionary=("-dict=tests/fuzz/$target.dict")
GUSTLAB_FUZZ_TARGET="$target" ASAN_OPTIONS=detect_leaks=1:quarantine_size_mb=16:malloc_context_size=8 UBSAN_OPTIONS=print_stacktrace=1 build/fuzz/fuzz_readers \
  "${dictionary[@]}" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 \
  -artifact_prefix="build/fuzz/found/$target." "${@:3}" "build/fuzz/corpus/$target" "tests/fuzz/corpus/$target"
