#!/usr/bin/env bash
# before a release: clones what is committed into an empty folder and runs the README's two commands there.
# usage: scripts/clean_room.sh [commit or branch]
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

commit="$(git rev-parse --verify --quiet "${1:-HEAD}^{commit}")" || {
  echo "clean_room: ${1:-HEAD}: no such commit" >&2
  exit 2
}
room="$(mktemp -d)"
trap 'rm -rf "$room"' EXIT
git clone --quiet --no-local . "$room/gustlab"
cd "$room/gustlab"
git checkout --quiet --detach "$commit"

# a home of its own and no settings of this user, so that nothing outside the clone helps or is left behind
mkdir "$room/home"
clean() { env -u GUSTLAB_HOME -u GUSTLAB_FLIGHTS -u MUJOCO_ROOT -u CMAKE_PREFIX_PATH HOME="$room/home" "$@"; }
clean scripts/test.sh
clean scripts/reproduce.sh

changed="$(git status --porcelain)"
[[ -z $changed ]] || { echo "clean_room: the commands left files that git does not ignore:"$'\n'"$changed" >&2; exit 1; }
left="$(find "$room/home" -type f -not -path '*/.cache/*' | sed "s|^$room/||")"
[[ -z $left ]] || { echo "clean_room: the commands wrote outside the clone:"$'\n'"$left" >&2; exit 1; }
echo "clean_room: $(git rev-parse --short=12 HEAD) passes" >&2
