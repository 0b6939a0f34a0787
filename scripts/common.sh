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
  forget_old_headers "build/$preset"
  cmake --build --preset "$preset" ${*:+--target "$@"}
}

# Has headers of packages precompiled anew where packages have changed: theirs are older than what was
# made of the ones before, so that to ninja nothing has changed, and clang refuses them.
forget_old_headers() {
  local headers
  headers=$({ dpkg-query -W '*-dev' 2> /dev/null || true; } | sha256sum)
  if [[ ! -f $1/headers || $(< "$1/headers") != "$headers" ]]; then
    find "$1" -name 'cmake_pch.hxx.[pg]ch' -delete
    printf '%s\n' "$headers" > "$1/headers"
  fi
}

# packages SECTION...: the names in those sections of scripts/packages.
packages() {
  awk -v sections=" $* " '
    { sub(/#.*/, "") }
    /^\[/ { gsub(/[][[:space:]]/, ""); wanted = index(sections, " " $0 " "); next }
    wanted && NF { print $1 }' scripts/packages
}
