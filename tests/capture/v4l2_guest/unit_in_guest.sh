#!/usr/bin/env bash
# Process 1 of the guest: systemd runs the camera node's unit there, as it is installed, on the test camera vivid.
#   unit_in_guest.sh UNIT PROGRAM OUT
# The unit records OUT/take by OUT/studio.toml; what it and the kernel say of it stands in OUT/unit.log, what another program
# may do under the same unit in OUT/probe.txt, and without it in OUT/outside.txt.
set -euo pipefail
unit=$1 program=$2
for folder in /run /var/lib /var/tmp; do mount -t tmpfs tmpfs "$folder"; done
out=/var/lib/out  # OUT may lie in /tmp, of which the unit has its own
mkdir "$out"
mount --bind "$3" "$out"
mount -t cgroup2 cgroup2 /sys/fs/cgroup
chgrp video /dev/video* && chmod 660 /dev/video*  # as udev does
units=/run/systemd/system
mkdir -p "$units"/{floatstage-capture,probe}.service.d
chmod 777 "$out"

cp "$unit" "$units/floatstage-capture.service"
# Another account and place, nothing of what it may do.
cat > "$units/floatstage-capture.service.d/here.conf" <<HERE
[Service]
User=nobody
ExecStart=
ExecStart=$program capture --config $out/studio.toml --record -o $out/take --seconds 6 --json $out/report.json
# Of the recorder, once it says that it is ready; by systemd itself, not under the unit.
ExecStartPost=+/bin/bash -c 'readlink /proc/\$MAINPID/exe; exec grep -E "^(NoNewPrivs|Seccomp|CapEff):" /proc/\$MAINPID/status'
ReadWritePaths=$out
Restart=no
StandardOutput=append:$out/unit.log
StandardError=append:$out/unit.log
HERE

cp "$unit" "$units/probe.service"
cat > "$units/probe.service.d/here.conf" <<HERE
[Unit]
After=floatstage-capture.service
[Service]
Type=oneshot
User=root
WatchdogSec=0
ExecStart=
ExecStart=/bin/bash $(dirname "$0")/probe.sh
Restart=no
StandardOutput=append:$out/probe.txt
StandardError=append:$out/probe.txt
HERE

cat > "$units/watch.service" <<HERE
[Unit]
DefaultDependencies=no
[Service]
Type=oneshot
TimeoutStartSec=infinity
StandardOutput=append:$out/watch.log
StandardError=append:$out/watch.log
ExecStart=/bin/bash $(dirname "$0")/watch_unit.sh $out
HERE
cat > "$units/guest.target" <<HERE
[Unit]
DefaultDependencies=no
Wants=watch.service
HERE
exec /lib/systemd/systemd --unit=guest.target --show-status=no
