#!/usr/bin/env bash
# Runs a command against a server of its own: with-server.sh TOILE COMMAND…
# The command finds the server's address in TOILE_URL.
set -euo pipefail

toile=$1
shift
folder=$(mktemp -d)
# On a busy machine the loop below may look before the server's shell has made it.
touch "$folder/address"
"$toile" serve --listen 127.0.0.1:0 --data "$folder/data" >"$folder/address" 2>"$folder/log" &
server=$!
stop() {
    kill -TERM "$server" 2>/dev/null && wait "$server" || true
    rm -rf "$folder"
}
trap stop EXIT

for _ in $(seq 600); do
    TOILE_URL=$(sed -n 's/^listening on //p' "$folder/address")
    if [ -n "$TOILE_URL" ] && node -e 'fetch(process.argv[1]).then((r) => process.exit(r.ok ? 0 : 1), () => process.exit(1))' "$TOILE_URL/readyz"; then
        export TOILE_URL
        "$@"
        exit
    fi
    if ! kill -0 "$server" 2>/dev/null; then break; fi
    sleep 0.3
done
echo "the server did not get ready:" >&2
cat "$folder/log" >&2
exit 1
