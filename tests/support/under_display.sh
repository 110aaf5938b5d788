#!/usr/bin/env bash
# under_display.sh COMMAND…: runs a command under a virtual display of its own and ends with its exit status.
# (xvfb-run ends with 5 now and then where several end at once: "problem while cleaning up".)
coproc SERVER { exec Xvfb -displayfd 1 -screen 0 1280x1024x24 -nolisten tcp 2> /dev/null; }
server=$SERVER_PID  # bash forgets it once the server has ended
trap 'kill $server 2> /dev/null; wait $server 2> /dev/null' EXIT
read -r number <&"${SERVER[0]}" || { echo "under_display.sh: no virtual display could be started" >&2; exit 99; }
DISPLAY=:$number "$@"
