# Sourced by the other scripts: leaves the shell at the top of the tree and stops it at any failure.

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '== %s\n' "$*"; }

# build PRESET [TARGET...]: configures, then builds what has changed.
build() {
  local preset=$1
  shift
  say "build $preset${*:+: $*}"
  cmake --preset "$preset" -Wno-dev --log-level=WARNING > /dev/null
  cmake --build --preset "$preset" ${*:+--target "$@"}
}

# packages SECTION...: the names in those sections of scripts/packages.
packages() {
  awk -v sections=" $* " '
    { sub(/#.*/, "") }
    /^\[/ { gsub(/[][[:space:]]/, ""); wanted = index(sections, " " $0 " "); next }
    wanted && NF { print $1 }' scripts/packages
}
