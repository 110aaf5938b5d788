#!/bin/bash
# A root with nothing in it but Debian's essential packages and what a package depends on:
#
#   bare_root.sh installed ROOT PACKAGE.deb   of this system's own files: no network, a few seconds. Holds exactly the packages that
#                                             the .deb's dependencies close over, and dpkg's records of them.
#   bare_root.sh mirror ROOT PACKAGE.deb      by mmdebstrap and apt from Debian's mirror: minutes, and some 400 MB from the network.
#
# Both leave the .deb in ROOT/tmp, ready for dpkg --install.
set -euo pipefail
how=$1 root=$2 deb=$3

# Names of all installed packages that the dependencies in $1, and Essential, close over. First alternative that is installed.
closure() {
  dpkg-query -W -f='${db:Status-Status}\t${Package}\t${Essential}\t${Provides}\t${Pre-Depends}, ${Depends}\n' |
    awk -F '\t' -v wanted="$1" '
      function names(list, into,    parts, i, n) {
        n = split(list, parts, /, */)
        for (i = 1; i <= n; i++) { gsub(/ *\([^)]*\)|:any|:amd64| /, "", parts[i]); into[i] = parts[i] }
        return n
      }
      function follow(list,    each, n, i, k, m, options, p) {
        n = names(list, each)
        for (i = 1; i <= n; i++) {
          m = split(each[i], options, "|")
          for (k = 1; k <= m; k++) {
            p = options[k]
            if (!(p in needs) && (p in provider)) p = provider[p]
            if (p in needs) { if (!(p in taken)) { taken[p] = 1; follow(needs[p]) } break }
          }
        }
      }
      $1 == "installed" {
        needs[$2] = $5
        if ($3 == "yes") essential = essential ", " $2
        n = names($4, each); for (i = 1; i <= n; i++) if (!(each[i] in provider)) provider[each[i]] = $2
      }
      END { follow(wanted essential); for (p in taken) print p }' | sort
}

from_installed() {
  mkdir -p "$root"/{usr/bin,usr/sbin,usr/lib,usr/lib64,etc/alternatives,dev,proc,run,tmp,var/log,var/lib/dpkg/info,var/lib/dpkg/updates,var/lib/dpkg/triggers}
  for name in bin sbin lib lib64; do ln -s "usr/$name" "$root/$name"; done
  chmod 1777 "$root/tmp"
  local packages list
  packages=$(closure "$(dpkg-deb -f "$deb" Depends)")
  list=$(mktemp)
  for package in $packages; do cat /var/lib/dpkg/info/"$package".list /var/lib/dpkg/info/"$package":*.list 2>/dev/null || true; done |
    grep -v -E '^/\.$|^/(s?bin|lib|lib64)$|^/usr/share/(doc|man|locale|info|lintian)/|^/(proc|dev|run|tmp)(/|$)' | sort -u > "$list"
  # Files that somebody took away from this system are not there either.
  xargs -d '\n' ls -d -- < "$list" 2>/dev/null > "$list.there" || true
  tar --create --absolute-names --no-recursion --files-from="$list.there" | tar --extract --keep-directory-symlink -C "$root"
  rm "$list" "$list.there"
  # What packages' scripts made: alternatives, accounts, the loader's cache, dpkg's records.
  find /usr/bin /usr/lib -lname '/etc/alternatives/*' | while read -r link; do
    target=$(readlink -f "$link")
    [ -e "$root$target" ] || continue
    mkdir -p "$root$(dirname "$link")"
    cp -P "$link" "$root$link"
    cp -P "$(readlink "$link")" "$root/etc/alternatives/"
  done
  cp /usr/share/base-passwd/passwd.master "$root/etc/passwd"
  cp /usr/share/base-passwd/group.master "$root/etc/group"
  awk -v taken="$packages" 'BEGIN { RS = ""; ORS = "\n\n"; n = split(taken, t, "\n"); for (i = 1; i <= n; i++) want[t[i]] = 1 }
    match($0, /^Package: [^\n]+/) { if (substr($0, 10, RLENGTH - 9) in want) print }' /var/lib/dpkg/status > "$root/var/lib/dpkg/status"
  for package in $packages; do cp /var/lib/dpkg/info/"$package"{,:*}.list "$root/var/lib/dpkg/info/" 2>/dev/null || true; done
  touch "$root/var/lib/dpkg/available"
  mknod -m 666 "$root/dev/null" c 1 3
  mknod -m 666 "$root/dev/zero" c 1 5
  mknod -m 666 "$root/dev/urandom" c 1 9
  chroot "$root" ldconfig
  chroot "$root" pwconv
  chroot "$root" grpconv
  echo "$packages" | wc -l
}

from_mirror() {
  mmdebstrap --quiet --mode=root --variant=apt bookworm "$root"
  # What has been fetched before is not fetched again.
  mkdir -p "$root/archives"
  mount --bind /var/cache/apt/archives "$root/archives"
  trap 'umount "$root/archives"; rmdir "$root/archives"' EXIT
  mount -t proc proc "$root/proc"
  chroot "$root" apt-get update -qq
  cp "$deb" "$root/tmp/"
  local missing
  missing=$(chroot "$root" apt-get install --simulate --no-install-recommends "/tmp/$(basename "$deb")" |
    sed -n 's/^Inst \([^ ]*\) .*/\1/p' | grep -v -x floatstage)
  # shellcheck disable=SC2086
  DEBIAN_FRONTEND=noninteractive chroot "$root" apt-get install -y -qq --no-install-recommends \
    -o Dir::Cache::Archives=/archives -o APT::Keep-Downloaded-Packages=true $missing
  umount "$root/proc"
}

case $how in
  installed) from_installed ;;
  mirror) from_mirror ;;
  *) echo "bare_root.sh installed|mirror ROOT PACKAGE.deb" >&2; exit 2 ;;
esac
cp "$deb" "$root/tmp/"
