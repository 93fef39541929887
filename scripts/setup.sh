#!/usr/bin/env bash
# installs what gustlab needs: Debian packages, and a Python environment in .venv/ with pinned versions.
# usage: scripts/setup.sh [--test | --cluster]    (--test adds what only the tests need; --cluster what scripts/fuzz.sh,
# scripts/test_slurm.sh and scripts/cluster/ need)
# as root or as a user with sudo; asks nothing; does nothing the second time.
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(
  ca-certificates git g++ cmake ninja-build pkg-config python3 python3-venv
  libeigen3-dev libtomlplusplus-dev libcli11-dev libfmt-dev libspdlog-dev nlohmann-json3-dev libsqlite3-dev
  libtbb-dev libceres-dev libnlopt-dev libnlopt-cxx-dev libboost-dev librandom123-dev zlib1g-dev libtinyxml2-dev
  libgtest-dev libgmock-dev libbenchmark-dev libosmesa6
)
requirements=(scripts/requirements.txt)
case "${1:-}" in
  "") ;;
  --test) requirements+=(scripts/requirements-test.txt) ;;
  --cluster) packages+=(clang-14 libclang-rt-14-dev slurm-wlm munge parallel openmpi-bin) ;;
  *) echo "usage: scripts/setup.sh [--test | --cluster]" >&2; exit 2 ;;
esac

# Debian packages that are not there yet
if command -v dpkg-query > /dev/null; then
  missing=()
  for package in "${packages[@]}"; do
    dpkg-query -W -f='${db:Status-Status}' "$package" 2> /dev/null | grep -qx installed || missing+=("$package")
  done
  if ((${#missing[@]})); then
    as_root=()
    if ((EUID != 0)); then
      command -v sudo > /dev/null || {
        echo "setup: missing Debian packages, and neither root nor sudo here; as root: apt-get install ${missing[*]}" >&2
        exit 4
      }
      as_root=(sudo)
    fi
    echo "setup: installing ${missing[*]}" >&2
    # a container is made anew when the power fails while packages are unpacked; writing each file through takes most of the time
    quickly=()
    [[ -d /run/systemd/system ]] || quickly=(-o Dpkg::Options::=--force-unsafe-io)
    "${as_root[@]}" apt-get -qq update
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get -qq -y "${quickly[@]}" --no-install-recommends install "${missing[@]}" > /dev/null
  fi
else
  echo "setup: not a Debian system; these must be there by other means: ${packages[*]}" >&2
fi

# one set-up at a time; a link to another checkout's environment is followed
venv="$(realpath -m .venv)"
exec 9< "$(dirname "$venv")"
flock 9

# Debian's own Python comes first, so that one found on PATH changes nothing
if ! "$venv/bin/python" -c "import pip" 2> /dev/null; then
  python=/usr/bin/python3
  [[ -x $python ]] || python=python3
  echo "setup: making .venv with $("$python" --version)" >&2
  rm -rf "$venv"
  "$python" -m venv "$venv"
fi

# pip runs only when a list of requirements differs from the one installed last
for list in "${requirements[@]}"; do
  installed="$venv/installed-$(basename "$list")"
  if ! cmp -s "$list" "$installed"; then
    echo "setup: installing $list" >&2
    # modules are compiled when they are first imported: most never are
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile --requirement "$list"
    cp "$list" "$installed"
  fi
done
