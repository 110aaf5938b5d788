#!/usr/bin/env bash
# What the unit of a camera node lets another program do in its place, a line each.
attempt() { local what=$1; shift; if "$@" > /dev/null 2>&1; then echo "$what: yes"; else echo "$what: no"; fi; }
attempt "a camera" bash -c ': < /dev/video0'
attempt "another device" bash -c ': < /dev/ttyS0'
attempt "a private network" bash -c 'echo x > /dev/udp/192.168.77.2/9'
attempt "a public network" bash -c 'echo x > /dev/udp/198.51.100.1/9'
attempt "a mount" mount -t tmpfs tmpfs /tmp
attempt "a namespace" unshare --net true
attempt "a file of the system" touch /var/lib/other
attempt "another personality" setarch --32bit true
