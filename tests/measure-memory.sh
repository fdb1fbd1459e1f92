#!/usr/bin/env bash
# Resident memory of a fresh server that takes in outfits and drapes each once: measure-memory.sh TOILE FILE…
# Prints it after the demo outfits are loaded, after every outfit was draped, and after a restart.
set -euo pipefail

toile=$1
shift
folder=$(mktemp -d)
server=
stop() {
    [ -z "$server" ] || { kill -TERM "$server" && wait "$server"; } 2>/dev/null || true
    server=
}
trap 'stop; rm -rf "$folder"' EXIT

start() {
    "$toile" serve --listen 127.0.0.1:0 --data "$folder/data" >"$folder/address" 2>"$folder/log" &
    server=$!
    for _ in $(seq 600); do
        url=$(sed -n 's/^listening on //p' "$folder/address")
        if [ -n "$url" ] && curl -sf "$url/readyz" >/dev/null; then return; fi
        sleep 0.2
    done
    cat "$folder/log" >&2
    exit 1
}

report() {
    awk -v what="$1" '/VmRSS/ { printf "%-24s %4d MB\n", what, $2 / 1000 }' "/proc/$server/status"
}

ids() {
    python3 -c 'import json, sys; print(*(outfit["id"] for outfit in json.load(sys.stdin)["data"]), sep="\n")'
}

drape_all() {
    curl -sf "$url/v1/outfits?limit=100" | ids | while read -r id; do
        curl -sf -o /dev/null -H 'content-type: application/json' "$url/v1/drapes" \
            -d "{\"outfit\": \"$id\", \"pose\": {\"kind\": \"preset\", \"id\": \"sitting\"}}"
    done
}

start
report "demo outfits loaded"
for file in "$@"; do curl -sf -o /dev/null -F "file=@$file" "$url/v1/outfits"; done
drape_all
report "all uploaded and draped"
stop
start
report "restarted, idle"
drape_all
report "restarted, all draped"
