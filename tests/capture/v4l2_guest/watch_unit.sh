#!/usr/bin/env bash
# Starts the units one after another, and turns the machine off. Part of unit_in_guest.sh.
out=$1
status=70
finish() {
  echo "$status" > "$out/guest.status"
  sync
  systemctl poweroff -ff
}
trap finish EXIT
# The exit status of a unit that records.
record() {
  local unit=$1.service
  systemctl start "$unit" || true
  until [[ $(systemctl show --value -p ActiveState "$unit") = @(inactive|failed) ]]; do sleep 0.3; done
  systemctl show --value -p ExecMainStatus "$unit"
}
for unit in floatstage-capture gige gige-without-packets gige-without-internet gige-without-addresses; do
  echo "$unit: $(record "$unit")" >> "$out/ended.txt"
done
status=0
bash "$(dirname "$0")/probe.sh" > "$out/outside.txt"
systemctl start probe.service
