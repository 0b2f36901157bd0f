#!/usr/bin/env bash
# Tests of the Debian packages: test_package.sh FOLDER [JOBS]. FOLDER has the packages of build_package.sh, and gets the second build.
# Each line of standard output is a claim that holds; the first that does not ends the script. `./dev test --all package` calls this.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)"
folder="$(cd "$1" && pwd -P)"
jobs="${2:-$(nproc)}"

passed() { echo "passed: $*"; }
fail() {
  echo "failed: $*" >&2
  exit 1
}

packages=("$folder"/espalier_*.deb "$folder"/espalier-dev_*.deb "$folder"/python3-espalier_*.deb)
for package in "${packages[@]}"; do [[ -f "$package" ]] || fail "there is no ${package##*/}: run ./dev package first"; done
program_package="${packages[0]}"

# lintian ends with 2 when there is an error; warnings are printed
lintian --fail-on error --allow-root "${packages[@]}" >"$folder/lintian.txt" 2>&1 || fail "lintian: $(grep '^E:' "$folder/lintian.txt")"
passed "lintian finds no error"

if dpkg-deb -c "$program_package" | grep '/handbook/.*\.gz$' >&2; then
  fail "these files of the handbook are packed, so links to them lead nowhere"
fi
passed "no file of the handbook is packed"

systemd-analyze security --offline=true --threshold=25 "$here/debian/espalier.service" >/dev/null ||
  fail "the exposure of espalier.service is above 2.5: systemd-analyze security"
passed "espalier.service is exposed by 2.5 at most"

# in another folder, at another time
if [[ "${ESPALIER_PACKAGE_BUILDS:-2}" == 2 ]]; then
  mkdir -p "$folder/second"
  "$here/build_package.sh" "$folder/second" "$jobs" >/dev/null
  for package in "${packages[@]}"; do
    cmp "$package" "$folder/second/${package##*/}" || fail "two builds of ${package##*/} differ"
  done
  passed "two builds have the same bytes"
fi

wheel="$(ls "$folder"/../wheels/espalier-*manylinux*.whl 2>/dev/null | head -n 1)"
[[ -n "$wheel" ]] || fail "there is no wheel in build/wheels: run ./dev package first"

# An older version, for upgrades: 0.1.0 had no recipe of a package, so this is the package of today under an older number, and beside it data
# that the server of 0.1.0 has written (tests/server/store). While /srv/kill is there, its last script ends dpkg, which has unpacked the newer files by then
older="$folder/older"
rm -rf "$older"
dpkg-deb -R "$program_package" "$older"
sed -i 's/^Version: .*/Version: 0.1.0~released/' "$older/DEBIAN/control"
sed -i '2i if [ "$1" = upgrade ] && [ -e /srv/kill ]; then kill -KILL "$PPID"; fi' "$older/DEBIAN/postrm"
dpkg-deb --root-owner-group -b "$older" "$folder/older.deb" >/dev/null
rm -rf "$older"

# what the pages show, for a project outside the source tree
root="$here/../.."
sources="$folder/sources"
rm -rf "$sources"
mkdir -p "$sources/grow"
block() { awk -v fence="\`\`\`$1" '$0 == "```" && inside { exit } inside { print } $0 == fence { inside = 1 }' "$root/docs/library.md"; }
block cmake >"$sources/grow/CMakeLists.txt"
block cpp >"$sources/grow/grow.cpp"
for file in "$sources"/grow/*; do [[ -s "$file" ]] || fail "docs/library.md has no ${file##*/}"; done

# what happens in the bare system; every command must succeed. A `!` before a command would hide its failure: use test
cat >"$folder/inside.sh" <<'INSIDE'
set -eux
cd /srv
apt-get update -qq
install() { DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null; }
# starts a server with a data folder: sets server and address
serve() {
  rm -f address.txt
  espalier serve --listen 127.0.0.1:0 --data "$1" >address.txt 2>server.log &
  server=$!
  until grep -q listening address.txt; do
    kill -0 "$server"
    sleep 0.1
  done
  address=$(sed 's/listening on //' address.txt)
}

# a wheel needs Python only
install python3-venv
python3 -m venv plants
plants/bin/pip install --quiet --no-index ./espalier-*.whl
env -i plants/bin/espalier self-test
rm -rf plants

# installed and used in less than a minute, with the download of what it needs
began=$(date +%s)
install ./older.deb
espalier run classic-weed -o weed.png
test "$(head -c 4 weed.png | tail -c 3)" = PNG
test $(($(date +%s) - began)) -lt 60
dpkg-query -W -f '${Version}' espalier | grep -qx '0.1.0~released'

# data of 0.1.0, where the service has its own
data=/var/lib/private/espalier
mkdir -p "$data"
cp version1.sqlite "$data/espalier.sqlite"
# the newer version has everything: a simulation with its state, which goes on
kept() {
  serve "$data"
  espalier connect "$address" get sim-d8f7b28eea29 state-hash | grep -q e21dc4ffabc3ee78
  espalier connect "$address" step sim-d8f7b28eea29 1
  kill "$server"
  wait "$server"
}

# upgraded while a server runs: the server goes on
serve data
plant=$(espalier connect "$address" create --gallery light-tree --environment constant --seed 7)
install ./espalier_*.deb
dpkg-query -W -f '${Version}' espalier | grep -qx "$(dpkg-deb -f ./espalier_*.deb Version)"
espalier connect "$address" step "$plant" 2
kill "$server"
wait "$server"
cmp version1.sqlite "$data/espalier.sqlite"
kept

# an upgrade that is killed half-way, and done again: the data stay as they were until the newer server reads them
dpkg -i older.deb
cp version1.sqlite "$data/espalier.sqlite"
rm -f "$data"/espalier.sqlite-*
touch kill
if dpkg -i ./espalier_*.deb; then exit 1; fi
dpkg-query -W -f '${db:Status-Status}' espalier | grep -qx half-installed
cmp version1.sqlite "$data/espalier.sqlite"
rm kill
dpkg -i ./espalier_*.deb
dpkg-query -W -f '${db:Status-Status} ${Version}' espalier | grep -qx "installed $(dpkg-deb -f ./espalier_*.deb Version)"
espalier --version
kept

# what came with it
espalier conformance --kind deterministic --quiet
for each in man/man1/espalier.1.gz man/man1/espalier-run.1.gz bash-completion/completions/espalier zsh/vendor-completions/_espalier \
  fish/vendor_completions.d/espalier.fish doc/espalier/handbook/index.html; do
  test -s "/usr/share/$each"
done
espalier self-test

# an environment of one's own, and a page of a plant
install ./python3-espalier_*.deb
cat >ceiling.py <<'PYTHON'
from espalier import Environment

class Ceiling(Environment):
    def answer(self, query):
        return [1 if query.position[1] < 6 else 0]

Ceiling.serve()
PYTHON
espalier run light-tree --environment 'stdio:python3 ceiling.py' -o tree.png -o tree.glb
python3 - <<'PYTHON'
from pathlib import Path
from espalier.viewing import View

page = View([Path("tree.glb").read_bytes()]).html()
assert "espalier.showPlant" in page and len(page) > 100_000, len(page)
PYTHON

# the development files: a plug-in in C, a project in C++, and the examples of the pages
install ./espalier-dev_*.deb g++ cmake make
examples=/usr/share/doc/espalier-dev/examples
cat >plant.l <<'MODEL'
Lsystem: 1
derivation length: 5
Axiom: A?E(1)
A > ?E(x) : x == 1 --> FA
endlsystem
MODEL
cc -shared -fPIC -I /usr/include/espalier $examples/plugin/ceiling.c -o libceiling.so
test "$(espalier derive plant.l --environment ./libceiling.so --quiet)" = 'FFFA?E(0)'
cmake -S grow -B grow/build -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build grow/build
test "$(grow/build/grow | tail -n 1)" = 'FFFA?E(0)'
# the component bmi links the most
cmake -S $examples/bmi -B bmi/build -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build bmi/build
echo '{"model": "plant.l", "outputs": ["count:F"]}' >plant-bmi.json
test "$(bmi/build/driver plant-bmi.json | tail -n 1)" = '5 d  count:F 5 1'
g++ -std=c++20 -shared -fPIC -I /usr/include/espalier -I /usr/include/espalier/clients/bmi -I $examples/bmi $examples/bmi/heat_plugin.cpp -o libheat.so
echo '7 9 1 0.2' >heat.cfg
test "$(espalier derive plant.l --environment ./libheat.so --quiet)" = 'A?E(0.7024000000000001)'
test -s /usr/share/doc/python3-espalier/examples/heat.py

# settings that a person changed and data stay when the package goes; data that a server has open stay when it is purged, too
echo '# changed' >>/etc/espalier/serve.toml
serve "$data"
espalier connect "$address" create --gallery classic-weed >/dev/null
test -s "$data/espalier.sqlite"
apt-get remove -y -qq espalier >/dev/null
test ! -e /usr/bin/espalier
grep -q changed /etc/espalier/serve.toml
test -s "$data/espalier.sqlite"
apt-get purge -y -qq espalier >/dev/null
test ! -e /etc/espalier/serve.toml
test -s "$data/espalier.sqlite"
kill "$server"
wait "$server"

# without a server they go
install ./espalier_*.deb
apt-get purge -y -qq espalier >/dev/null
test ! -e "$data"
INSIDE

mmdebstrap --variant=apt --quiet --include=ca-certificates \
  --customize-hook="copy-in '${packages[0]}' '${packages[1]}' '${packages[2]}' '$folder/older.deb' '$wheel' '$root/tests/server/store/fixtures/version1.sqlite' '$sources/grow' '$folder/inside.sh' /srv" \
  --customize-hook='chroot "$1" sh /srv/inside.sh' \
  bookworm /dev/null >"$folder/bare.log" 2>&1 || fail "in a bare Debian 12: $(tail -n 12 "$folder/bare.log")"
passed "in a bare Debian 12: wheel, package installed and used in a minute, upgraded under a running server and after a kill with data of 0.1.0, C and C++ built, removed, purged"
