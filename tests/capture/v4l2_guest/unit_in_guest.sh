#!/usr/bin/env bash
# Process 1 of the guest: systemd runs the camera node's unit there, as it is installed, on the test camera vivid and on a
# fake GigE camera.
#   unit_in_guest.sh UNIT PROGRAM OUT
# The unit records OUT/take by OUT/studio.toml; what it and the kernel say of it stands in OUT/floatstage-capture.log. Then it
# records OUT/gige by OUT/gige.toml (gige.log), and again with less than it is allowed; how each ended stands in
# OUT/ended.txt. What another program may do under the same unit is in OUT/probe.txt, and without it in OUT/outside.txt.
set -euo pipefail
unit=$1 program=$2
for folder in /run /var/lib /var/tmp; do mount -t tmpfs tmpfs "$folder"; done
out=/var/lib/out  # OUT may lie in /tmp, of which the unit has its own
mkdir "$out"
mount --bind "$3" "$out"
mount -t cgroup2 cgroup2 /sys/fs/cgroup
chgrp video /dev/video* && chmod 660 /dev/video*  # as udev does
units=/run/systemd/system
mkdir -p "$units/probe.service.d"
chmod 777 "$out"

# A GigE camera on a network of its own, as if it were plugged in: Aravis' fake one. Beyond it lies the world.
ip netns add camera
ip link add studio0 type veth peer name eth0 netns camera
ip address add 192.168.77.1/24 dev studio0
ip link set studio0 up
ip -n camera address add 192.168.77.2/24 dev eth0
ip -n camera link set eth0 up
ip route add default via 192.168.77.2
ip netns exec camera arv-fake-gv-camera-0.8 -i 192.168.77.2 -s FAKE1 > "$out/camera.log" 2>&1 &

# recorder NAME STUDIO SECONDS TAKE: the unit as it is installed under this name; another account and place, and of what it may
# do only what standard input says.
recorder() {
  mkdir -p "$units/$1.service.d"
  cp "$unit" "$units/$1.service"
  cat > "$units/$1.service.d/here.conf" <<HERE
[Service]
User=nobody
ExecStart=
ExecStart=$program capture --config $out/$2 --record -o $out/$4 --seconds $3 --json $out/$4.json
# Of the recorder, once it says that it is ready; by systemd itself, not under the unit.
ExecStartPost=+/bin/bash -c 'readlink /proc/\$MAINPID/exe; grep -E "^(NoNewPrivs|Seccomp|CapEff):" /proc/\$MAINPID/status; echo "packet sockets: \$((\$(wc -l < /proc/net/packet) - 1))"'
ReadWritePaths=$out
Restart=no
StandardOutput=append:$out/$1.log
StandardError=append:$out/$1.log
HERE
  cat >> "$units/$1.service.d/here.conf"
}
recorder floatstage-capture studio.toml 6 take < /dev/null
recorder gige gige.toml 2 gige < /dev/null
recorder gige-without-addresses gige.toml 1 none <<< "IPAddressAllow="
recorder gige-without-internet gige.toml 1 none <<< "RestrictAddressFamilies=~AF_INET"
recorder gige-without-packets gige.toml 1 fallback <<< "RestrictAddressFamilies=~AF_PACKET"

cp "$unit" "$units/probe.service"
cat > "$units/probe.service.d/here.conf" <<HERE
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
