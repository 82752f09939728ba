#!/usr/bin/env bash
# Sets Ejecta up on Debian 12 and works with it.
#   ./bootstrap.sh build     installs what is missing, builds the program: build/ejecta
#   ./bootstrap.sh run       builds, runs cases/whipple_double, reports it: runs/whipple_double-hybrid/report.html
#   ./bootstrap.sh test      builds with tests, runs those labelled unit and verification
# Packages are installed as root, or through sudo; nothing is installed when all are there.
set -euo pipefail
cd "$(dirname "$0")"

compiler=(g++ cmake ninja-build pkg-config)
libraries=(libeigen3-dev libhdf5-dev libtomlplusplus-dev libcli11-dev libfmt-dev nlohmann-json3-dev)
pictures=(python3-numpy python3-h5py python3-matplotlib)
tests=(libgtest-dev)

say() { printf '\n== %s\n' "$*"; }
fail() { printf 'bootstrap.sh: %s\n' "$*" >&2; exit 1; }

missing_of() {
  for package in "$@"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || echo "$package"
  done
}

# install PACKAGE...: those of them that are not there yet
install() {
  command -v dpkg-query >/dev/null || fail "this is no Debian system: install the equivalents of: $*, then use cmake --preset release"
  local missing
  mapfile -t missing < <(missing_of "$@")
  ((${#missing[@]})) || return 0
  say "installing ${missing[*]}"
  local as_root=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null || fail "not root and no sudo: ask for these packages to be installed: ${missing[*]}"
    as_root=(sudo)
  fi
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0)
  "${apt[@]}" update >/dev/null || fail "apt-get update failed: is there a network, and are the package sources right?"
  "${apt[@]}" install --no-install-recommends "${missing[@]}" >/dev/null ||
    fail "these packages could not be installed: ${missing[*]}"
}

# build ON|OFF: with tests or without
build() {
  say "building (tests $1)"
  local options=(-DEJECTA_TESTS="$1")
  if command -v ccache >/dev/null; then
    options+=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  local log
  log=$(mktemp)
  cmake --preset release "${options[@]}" >"$log" 2>&1 || { cat "$log" >&2; rm -f "$log"; fail "cmake could not configure the build"; }
  rm -f "$log"
  cmake --build --preset release || fail "the build failed: see above"
  [[ -x build/ejecta ]] || fail "the build left no build/ejecta"
}

case ${1:-} in
  build)
    install "${compiler[@]}" "${libraries[@]}"
    build OFF
    say "the program is build/ejecta; try: ./bootstrap.sh run"
    ;;
  run)
    install "${compiler[@]}" "${libraries[@]}" "${pictures[@]}"
    build OFF
    say "running cases/whipple_double (a few minutes)"
    build/ejecta run cases/whipple_double --force
    say "drawing"
    build/ejecta report runs/whipple_double-hybrid
    say "done: runs/whipple_double-hybrid/report.html with picture cloud.png, numbers in summary.json"
    ;;
  test)
    install "${compiler[@]}" "${libraries[@]}" "${tests[@]}" "${pictures[@]}"
    build ON
    say "testing"
    ctest --test-dir build -L "unit|verification" --output-on-failure --no-tests=error -j2
    ;;
  *)
    sed -n '2,6s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac
