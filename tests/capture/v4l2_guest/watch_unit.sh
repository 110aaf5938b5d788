#!/usr/bin/env bash
# Starts the unit, waits for its end, and turns the machine off. Part of unit_in_guest.sh.
out=$1
status=70
finish() {
  echo "$status" > "$out/guest.status"
  sync
  systemctl poweroff -ff
}
trap finish EXIT
systemctl start floatstage-capture.service || { systemctl status --no-pager -n 0 floatstage-capture.service; exit; }
until [ "$(systemctl show --value -p SubState floatstage-capture.service)" = dead ] ||
      [ "$(systemctl show --value -p ActiveState floatstage-capture.service)" = failed ]; do
  sleep 0.5
done
status=$(systemctl show --value -p ExecMainStatus floatstage-capture.service)
[ "$(systemctl show --value -p Result floatstage-capture.service)" = success ] || status=71
bash "$(dirname "$0")/probe.sh" > "$out/outside.txt"
systemctl start probe.service
