#!/bin/sh
# What the program is made of, as an SPDX 2.3 document (tag and value): spdx.sh SOURCES PROGRAM VERSION OUT.
#
# Packages whose libraries the program loads are DYNAMIC_LINK; the others of packages.txt BUILD_DEPENDENCY_OF. Debian's own
# copyright files are the source of the licences: their short names stand in a comment, because such a file speaks of all
# sources of a package, and which of them went into one library it does not say.
set -eu
installed=$(dpkg-query -W -f='${db:Status-Status} ${Package} ${Version}\n' | sed -n 's/^installed //p')
sources=$1 program=$2 version=$3 out=$4

licences() { # of a package's copyright file, sorted
  file=/usr/share/doc/$1/copyright
  [ -f "$file" ] || { echo "see /usr/share/doc/$1"; return; }
  names=$(sed -n 's/^License: *//p' "$file" | sort -u | paste -sd ';' -)
  echo "${names:-see $file}"
}

package() { # name, relationship
  version_of=$(echo "$installed" | sed -n "s|^$1 ||p" | head -1)
  [ -n "$version_of" ] || return 0
  id=SPDXRef-$(echo "$1" | tr -c 'A-Za-z0-9.\n' '-')
  printf 'PackageName: %s\nSPDXID: %s\nPackageVersion: %s\nPackageSupplier: Organization: Debian\n' "$1" "$id" "$version_of"
  printf 'PackageDownloadLocation: NOASSERTION\nFilesAnalyzed: false\n'
  printf 'PackageLicenseConcluded: NOASSERTION\nPackageLicenseDeclared: NOASSERTION\nPackageCopyrightText: NOASSERTION\n'
  printf 'PackageLicenseComments: <text>%s</text>\n' "$(licences "$1")"
  printf 'ExternalRef: PACKAGE-MANAGER purl pkg:deb/debian/%s@%s\n' "$1" "$version_of"
  case $2 in
    linked) printf 'Relationship: SPDXRef-floatstage DYNAMIC_LINK %s\n\n' "$id" ;;
    *) printf 'Relationship: %s BUILD_DEPENDENCY_OF SPDXRef-floatstage\n\n' "$id" ;;
  esac
}

# Packages of the libraries that the program names itself. A library is asked for by the names that packages may know it by:
# as the loader finds it, below /usr, and behind the links of alternatives. Patterns would take minutes.
named=$(objdump -p "$program" | sed -n 's/^ *NEEDED *//p')
linked=$(ldd "$program" | awk -v named="$named" 'BEGIN { split(named, n); for (i in n) want[n[i]] = 1 } $1 in want { print $3 }' |
  while read -r path; do printf '%s\n%s\n%s\n' "$path" "/usr$path" "$(readlink -f "$path")"; done |
  xargs dpkg-query -S 2>/dev/null | sed 's/:.*//' | sort -u)
wanted=$(sed -e 's/#.*//' -e '/^\s*$/d' "$sources/packages.txt" | sort -u)

{
  printf 'SPDXVersion: SPDX-2.3\nDataLicense: CC0-1.0\nSPDXID: SPDXRef-DOCUMENT\nDocumentName: floatstage-%s\n' "$version"
  printf 'DocumentNamespace: urn:floatstage:spdx:%s\nCreator: Tool: packaging/spdx.sh\nCreated: %s\n' "$version" \
    "$(date -u -d "@${SOURCE_DATE_EPOCH:-0}" +%Y-%m-%dT%H:%M:%SZ)"
  printf 'Relationship: SPDXRef-DOCUMENT DESCRIBES SPDXRef-floatstage\n\n'
  printf 'PackageName: floatstage\nSPDXID: SPDXRef-floatstage\nPackageVersion: %s\n' "$version"
  printf 'PackageDownloadLocation: NOASSERTION\nFilesAnalyzed: false\nPackageLicenseDeclared: MIT\n'
  printf 'PackageLicenseConcluded: GPL-3.0-or-later\nPackageCopyrightText: 2026 The Floatstage authors\n'
  printf 'PackageLicenseComments: <text>sources MIT; linked with libraries under the GPL: docs/licence.md</text>\n\n'
  for name in $linked; do package "$name" linked; done
  for name in $wanted; do echo "$linked" | grep -qx "$name" || package "$name" built; done
} > "$out.tmp"
mv "$out.tmp" "$out"
