#!/usr/bin/env bash
# Unpacks Debian's kernel into a folder, without installing it: fetch_kernel.sh FOLDER. Does nothing when it is there.
set -euo pipefail
folder=$1
[ -f "$folder/complete" ] && exit 0
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
package=$(apt-cache depends linux-image-amd64 | awk '/Depends:/ { print $2; exit }')
[ -n "$package" ] || { echo "apt knows no linux-image-amd64; run: apt-get update" >&2; exit 69; }
(cd "$work" && apt-get download "$package" >&2)
rm -rf "$folder"
mkdir -p "$folder"
dpkg -x "$work"/*.deb "$folder"
touch "$folder/complete"
