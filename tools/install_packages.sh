#!/usr/bin/env bash
# Installs those of tools/packages.txt, or of the file given, that are missing, and nothing else; at once when none is.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t wanted < <(sed 's/#.*//' "${1:-tools/packages.txt}" | xargs -n1)

if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  echo "packages: this is not Debian; please see to these yourself: ${wanted[*]}" >&2
  exit 0
fi

is_installed() { [[ $(dpkg-query -W -f='${db:Status-Status}' "$1" 2> /dev/null || true) == installed ]]; }

# Those that are missing; of "A|B" the first that this release has.
find_missing() {
  local line package candidate
  missing=()
  for line in "${wanted[@]}"; do
    candidate=
    for package in ${line//|/ }; do
      if is_installed "$package"; then continue 2; fi
      [[ -n $candidate || -z $(apt-cache madison "$package" 2> /dev/null) ]] || candidate=$package
    done
    missing+=("${candidate:-${line%%|*}}")
  done
}

find_missing
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "packages: all ${#wanted[@]} are installed"
  exit 0
fi

echo "packages: installing ${missing[*]}"
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo > /dev/null; then
    echo "error: not root, and there is no sudo." >&2
    echo "  fix:  as root, apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}" > "$log" 2>&1
}
# The package lists at hand often suffice; fetch new ones only when they do not.
if ! install; then
  "${as_root[@]}" apt-get update -qq > "$log" 2>&1 || true  # the next lines tell whether that helped
  find_missing
  if ! install; then
    tail -n 20 "$log" >&2
    echo "error: could not install ${missing[*]}." >&2
    echo "  fix:  offline? Connect once, or install them from a mirror: apt-get install --no-install-recommends ..." >&2
    exit 1
  fi
fi
