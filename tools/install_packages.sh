#!/usr/bin/env bash
# Installs the packages of tools/packages.txt that are missing, with CI=true those marked "ci", too. Prints nothing when
# none is.
set -euo pipefail
export LC_ALL=C DEBIAN_FRONTEND=noninteractive

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mapfile -t packages < <(awk '{ sub(/#.*/, "") } NF == 1 { print $1 }' "$here/packages.txt")
if [ "${CI:-}" = true ]; then
  while read -r command package; do
    command -v "$command" > /dev/null || packages+=("$package")
  done < <(awk '$1 == "ci" { print $2, $3 }' "$here/packages.txt")
fi

if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  echo "install_packages: not a Debian system; install what provides these packages: ${packages[*]}" >&2
  exit 2
fi

# One query for all: dpkg-query fails for names it has never heard of, which are missing, too.
installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${packages[@]}" 2> /dev/null || true)
missing=()
for package in "${packages[@]}"; do
  grep -qxF "installed $package" <<< "$installed" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo > /dev/null; then
    echo "install_packages: needs root or sudo to install: ${missing[*]}" >&2
    exit 2
  fi
  as_root=(sudo env "LC_ALL=$LC_ALL" "DEBIAN_FRONTEND=$DEBIAN_FRONTEND")
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# Another installation may hold the lock: wait for it.
apt_get() {
  if ! "${as_root[@]}" apt-get -y -o DPkg::Lock::Timeout=300 "$@" > "$log" 2>&1 < /dev/null; then
    cat "$log" >&2
    echo "install_packages: apt-get $1 failed" >&2
    exit 2
  fi
}
echo "Installing: ${missing[*]}" >&2
apt_get update
apt_get install --no-install-recommends "${missing[@]}"
