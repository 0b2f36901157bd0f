#!/usr/bin/env bash
# Tests of the image: test_image.sh FOLDER. FOLDER has espalier_*.deb. Each line of standard output is a claim that holds; the first that does not
# ends the script. `./dev test --all package` calls this.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)"
folder="$(cd "$1" && pwd -P)"
work="$folder/image"
buildah="buildah --storage-driver vfs --root $work/store --runroot $work/run"

passed() { echo "passed: $*"; }
fail() {
  echo "failed: $*" >&2
  exit 1
}

mkdir -p "$work"
"$here/build_image.sh" "$folder" espalier-test >"$work/build.log" 2>&1 || fail "the image is not built: $(tail -n 8 "$work/build.log")"
passed "an image is built without a daemon"

container="$($buildah from espalier-test)"
server=""
finish() {
  [[ -z "$server" ]] || kill "$server" 2>/dev/null || true
  $buildah rm "$container" >/dev/null
}
trap finish EXIT
inside() { $buildah run --isolation chroot "$@"; }

inside "$container" -- /usr/bin/espalier run classic-weed -o weed.png 2>"$work/run.log" || fail "run: $(cat "$work/run.log")"
inside "$container" -- sh -c 'test "$(id -u)" = 990 && test -s weed.png' || fail "a picture is not drawn by the user 990"
passed "an ordinary user of the container draws a picture"

# the command of the image, with ports that are free here
words="$($buildah inspect --format '{{range .OCIv1.Config.Entrypoint}}{{.}} {{end}}{{range .OCIv1.Config.Cmd}}{{.}} {{end}}' "$container")"
free() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.2", 0)); print(s.getsockname()[1])'; }
tcp="$(free)" http="$(free)"
words="$(sed "s/:4321 /:$tcp /; s/:8080 /:$http /" <<<"$words")"

# shellcheck disable=SC2086 # several words
inside "$container" -- $words >"$work/none.log" 2>&1 && fail "the server starts without a token"
grep -q container.toml "$work/none.log" || fail "the message does not name the file of the tokens: $(cat "$work/none.log")"
passed "without tokens the server does not start, and names the file"

{
  echo "[tokens]"
  inside "$container" -- /usr/bin/espalier token new outside -o outside.token 2>/dev/null
} >"$work/token.toml"
inside "$container" -- cat outside.token >"$work/outside.token"
chmod 600 "$work/outside.token"
# shellcheck disable=SC2086 # several words
inside --volume "$work/token.toml:/etc/espalier/container.toml:ro" "$container" -- $words >"$work/server.log" 2>&1 &
server=$!
until grep -q "listening on" "$work/server.log"; do
  kill -0 "$server" 2>/dev/null || fail "the server ended: $(cat "$work/server.log")"
  sleep 0.2
done
# another address than 127.0.0.1: a server that listens there alone is not reached, as one in a container is not
python3 - "$http" <<'PYTHON' || fail "the HTTP side is not reached from outside"
import sys, urllib.request
assert urllib.request.urlopen(f"http://127.0.0.2:{sys.argv[1]}/health", timeout=60).status == 200
PYTHON
program="${ESPALIER_PROGRAM:-$here/../../build/release/bin/espalier}"
"$program" connect "127.0.0.2:$tcp" list >/dev/null 2>"$work/refused.log" && fail "a program without a token is let in"
grep -qi token "$work/refused.log" || fail "the refusal does not name the token: $(cat "$work/refused.log")"
plant="$("$program" connect "127.0.0.2:$tcp" --token-file "$work/outside.token" create --gallery classic-weed)"
"$program" connect "127.0.0.2:$tcp" --token-file "$work/outside.token" step "$plant" 2 >/dev/null
passed "a server in the container is reached from outside by those who have the token"
