"""Hostile peers of every kind at once, against one server, and a client that means well among them.

Strangers without the token: silent connections, slow ones, half a message and gone, floods, nonsense, on each transport.
Peers with the token: models that explode while they are compiled or grown, pictures of a few bytes that stand for much, snapshots with wrong bytes, streams that are
opened and closed, ids that are used twice, answers that are never read, WebSockets with wrong frames, numbers of every kind
where others belong, simulations that fill the disk. The server has few descriptors, little memory and little room on its
disk, and its wall clock jumps. The client that means well must get every answer, and its waiting times are printed. What
was answered as saved is there after the server was killed.

Where there is a C compiler the clock jumps (tests/support/shifted_clock.c); where this process may make control groups the
server is in one that bounds its memory. What is missing is printed.
"""

import base64
import json
import multiprocessing
import os
import random
import shutil
import socket
import ssl
import statistics
import struct
import subprocess
import threading
import time
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Set

from support import Process, program

from espalier import Client, EspalierError, ServerError

PROCESSES = multiprocessing.get_context("fork")
SECONDS = 60
CLOCK_SOURCE = Path(__file__).parents[1] / "support" / "shifted_clock.c"
# of the control group; the limit memoryBytes is 150 MB, and the C library keeps freed memory for each thread
GROUP_BYTES = 700_000_000
TOKEN = "means well"
DOUBLING = "Lsystem: 1\nderivation length: 60\nAxiom: A(1)\nA(x) --> A(x)A(x)\nendlsystem\n"
STEADY = "Lsystem: 1\nderivation length: 1000000\nAxiom: A(0.5)\nA(x) --> A(ran(1)+x/2)\nendlsystem\n"
# twice as many random numbers after each step, which do not compress
NOISE = "Lsystem: 1\nderivation length: 60\nAxiom: A(1)\nA(x) --> A(ran(1))A(ran(1))\nendlsystem\n"
HELLO = b'{"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"roles":["controller"],"token":"means well"}}\n'
UPGRADE = (b"GET /espalier/1 HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
           b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n")


def macro_bomb() -> str:
    lines = ["#define A 0123456789"]
    for last, name in zip("ABCDEF", "BCDEFG"):
        lines.append(f"#define {name} " + " ".join([last] * 12))
    return "\n".join(lines + ["Lsystem: 1", "derivation length: 1", "Axiom: F(G)", "F --> F", "endlsystem", ""])


def png_bomb() -> bytes:
    """A black picture of 8,000 by 8,000 pixels, which are 256 MB, in 8 kB."""
    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", 8000, 8000, 1, 0, 0, 0, 0)
    rows = zlib.compress(bytes(8000 * 1001), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def jpeg_bomb() -> bytes:
    """A progressive picture of 2,000 by 2,000 pixels whose last scan comes 50,000 times. Each scan goes over all pixels."""
    picture = bytearray((Path(__file__).parents[1] / "engine" / "files" / "images" / "progressive.jpg").read_bytes())
    size = picture.index(b"\xff\xc2") + 5
    picture[size:size + 4] = struct.pack(">HH", 2000, 2000)
    scan = picture.rindex(b"\xff\xda")
    return bytes(picture[:-2] + picture[scan:-2] * 50_000 + picture[-2:])


def model_with_picture(name: str, picture: bytes) -> Dict[str, Any]:
    return {"files": {"tree.l": STEADY, "tree.v": f"texture: F {name}\n"}, "main": "tree.l",
            "binaryFiles": {name: base64.b64encode(picture).decode("ascii")}}


def checksum(content: bytes) -> bytes:
    """Of a snapshot, as engine/core/hash.h makes it."""
    value = 0xcbf29ce484222325
    for byte in content:
        value = (value ^ byte) * 0x100000001b3 % 2**64
    return struct.pack("<Q", value)


@dataclass
class Surroundings:
    """The conditions in which the server runs."""

    folder: Path
    is_encrypted: bool = False
    clock: Optional[Path] = None  # a file that says how far the wall clock is off
    group: Optional[Path] = None  # a control group that bounds its memory

    @property
    def clock_library(self) -> Path:
        return self.folder / "shifted_clock.so"

    @property
    def certificate(self) -> Path:
        return self.folder / "certificate.pem"

    @property
    def scheme(self) -> str:
        return "tls://" if self.is_encrypted else ""

    def prepare(self) -> None:
        if self.is_encrypted:
            subprocess.run(
                ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                 "-keyout", str(self.folder / "key.pem"), "-out", str(self.certificate), "-subj", "/CN=localhost",
                 "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"], check=True, capture_output=True)
            # the clients of this process and of its children trust it
            os.environ["SSL_CERT_FILE"] = str(self.certificate)
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler:
            subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", str(self.clock_library), str(CLOCK_SOURCE)], check=True)
            self.clock = self.folder / "clock"
            self.clock.write_text("+0\n", encoding="ascii")
        else:
            print("the clock does not jump: there is no C compiler")
        self.group = memory_group()
        if self.group is None:
            print("no control group bounds the server: this process may not make one")

    def clean(self) -> None:
        os.environ.pop("SSL_CERT_FILE", None)
        if self.group is not None:
            self.group.rmdir()

    def serve(self) -> Process:
        settings = {}
        if self.clock is not None:
            # steps and time-outs go by the other clock, which does not jump
            settings = {"LD_PRELOAD": str(self.clock_library), "CLOCK_SHIFT_FILE": str(self.clock)}
        enter = f"echo $$ > '{self.group}/cgroup.procs'; " if self.group is not None else ""
        variables = " ".join(f"{name}='{value}'" for name, value in settings.items())
        encryption = f"--certificate '{self.certificate}' --key '{self.folder}/key.pem'" if self.is_encrypted else ""
        return Process(["bash", "-c", f"{enter}ulimit -n 200; exec env {variables} '{program()}' serve --listen 127.0.0.1:0 "
                                      f"--http 127.0.0.1:0 {encryption} --token '{TOKEN}' --data '{self.folder}/data' "
                                      "--log-level off --limit memoryBytes=150000000 --limit storeBytes=20000000 "
                                      "--limit callSeconds=2 --limit handshakeMilliseconds=1000"])


def memory_group() -> Optional[Path]:
    """A control group with GROUP_BYTES of memory; None where this process may not make one."""
    for root, bound in ((Path("/sys/fs/cgroup/memory"), "memory.limit_in_bytes"), (Path("/sys/fs/cgroup"), "memory.max")):
        group = root / f"espalier-hostility-{os.getpid()}"
        try:
            group.mkdir()
        except OSError:
            continue
        try:
            (group / bound).write_text(str(GROUP_BYTES), encoding="ascii")
            return group
        except OSError:
            group.rmdir()
    return None


def mean_well(address: str, end: float, sender: Any) -> None:
    """Steps of the client that means well, in a process of its own; sends what went wrong and how long each step took."""
    failures: List[str] = []
    waits: List[float] = []
    try:
        with Client(address, timeout=SECONDS, token=TOKEN) as client:
            plant = client.create(STEADY, seed=4, save=False)
            while time.monotonic() < end and not failures:
                begin = time.monotonic()
                found = client.call("simulation.step", {"simulation": plant.identifier})["step"]
                waits.append(time.monotonic() - begin)
                if found != len(waits):
                    failures.append(f"the simulation is at step {found} instead of {len(waits)}")
                if found % 50 == 0:
                    with Client(address, timeout=SECONDS, token=TOKEN) as newcomer:
                        newcomer.call("ping", {})
                time.sleep(0.005)
    except (OSError, EspalierError) as error:
        failures.append(f"the client that means well: {type(error).__name__}: {error}")
    sender.send((failures, waits))


class Hostility:
    """Parts that are repeated, each in a thread of its own, until the time is over or something is wrong."""

    def __init__(self, surroundings: Surroundings, address: str, http: str, seconds: float) -> None:
        self.surroundings = surroundings
        self.sides = {"protocol": self._pair(address), "http": self._pair(http)}
        self.address = surroundings.scheme + address
        self.trusting = ssl.create_default_context(cafile=str(surroundings.certificate)) if surroundings.is_encrypted else None
        self.end = time.monotonic() + seconds
        self.counts: Dict[str, int] = {}
        self.failures: List[str] = []
        self.waits: List[float] = []
        self._lock = threading.Lock()
        self.saved = ""
        self.saved_step = 0
        self.pictures = [model_with_picture("bark.png", png_bomb()), model_with_picture("bark.jpg", jpeg_bomb())]

    @staticmethod
    def _pair(address: str) -> Any:
        host, port = address.rsplit(":", 1)
        return host, int(port)

    def count(self, what: str) -> None:
        with self._lock:
            self.counts[what] = self.counts.get(what, 0) + 1

    def look_for_bug(self, error: ServerError, asked: str) -> None:
        if error.code == -32603:
            self.failures.append(f"{asked} was answered by a bug: {error}")

    def run(self, parts: List[Callable[[random.Random], None]]) -> None:
        def repeat(body: Callable[[random.Random], None], dice: random.Random) -> None:
            while time.monotonic() < self.end and not self.failures:
                try:
                    body(dice)
                except (OSError, EspalierError):
                    # the server may refuse, close and be short of anything for peers like these
                    self.count("refusals")
                    time.sleep(0.01)
                except Exception as error:  # noqa: BLE001
                    self.failures.append(f"{body.__name__}: {type(error).__name__}: {error}")

        here, there = PROCESSES.Pipe()
        well = PROCESSES.Process(target=mean_well, args=(self.address, self.end, there))
        well.start()
        threads = [threading.Thread(target=repeat, args=(body, random.Random(seed)), daemon=True)
                   for seed, body in enumerate(parts)]
        for thread in threads:
            thread.start()
        problems, self.waits = here.recv()
        self.failures += problems
        well.join()
        for thread in threads:
            thread.join(SECONDS)

    # ---- strangers

    def connect_plainly(self, side: str) -> socket.socket:
        """A connection whose peer does not begin TLS."""
        peer = socket.create_connection(self.sides[side], 10)
        peer.settimeout(5)
        return peer

    def connect(self, side: str) -> socket.socket:
        peer = self.connect_plainly(side)
        return peer if self.trusting is None else self.trusting.wrap_socket(peer, server_hostname="localhost")

    def stay_silent(self, dice: random.Random) -> None:
        peers = [self.connect_plainly(dice.choice(("protocol", "http"))) for _ in range(20)]
        time.sleep(dice.uniform(0.1, 1.0))
        for peer in peers:
            peer.close()
        self.count("silent")

    def drip(self, dice: random.Random) -> None:
        """A letter at a time, on each transport."""
        side, text = dice.choice((("protocol", HELLO.replace(b"means well", b"guess")), ("http", UPGRADE),
                                  ("http", b"GET /metrics HTTP/1.1\r\nX: " + b"y" * 1000)))
        with dice.choice((self.connect, self.connect_plainly))(side) as peer:
            for letter in text[:dice.randrange(1, 80)]:
                peer.sendall(bytes([letter]))
                time.sleep(0.01)
        self.count("slow")

    def vanish(self, dice: random.Random) -> None:
        """Half a message, and a reset instead of an end."""
        side, text = dice.choice((("protocol", HELLO), ("http", UPGRADE)))
        peer = dice.choice((self.connect, self.connect_plainly))(side)
        peer.sendall(text[:dice.randrange(len(text))])
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        peer.close()
        self.count("vanished")
        time.sleep(0.005)

    def flood(self, dice: random.Random) -> None:
        side = dice.choice(("protocol", "http"))
        text = dice.choice((b"x" * 1_000_000, b'{"jsonrpc":"2.0","id":1,"method":"ping"}\n' * 5_000, b"[" * 100_000 + b"\n",
                            bytes(dice.randrange(256) for _ in range(10_000)), UPGRADE * 50))
        with dice.choice((self.connect, self.connect_plainly))(side) as peer:
            peer.sendall(text)
        self.count("floods")

    # ---- peers with the token

    def trusted(self) -> Client:
        return Client(self.address, timeout=SECONDS, token=TOKEN)

    def explode(self, dice: random.Random) -> None:
        """Models that need more than there is."""
        with self.trusted() as client:
            try:
                way = dice.random() if "pictures" in self.counts else 0.25  # a busy machine makes few of these
                if way < 0.25:
                    client.check(macro_bomb())
                elif way < 0.5:
                    self.count("pictures")
                    client.call("model.check", dice.choice(self.pictures))
                else:
                    plant = client.create(DOUBLING, seed=1)
                    try:
                        client.call("simulation.run", {"simulation": plant.identifier})
                    finally:
                        client.call("simulation.delete", {"simulation": plant.identifier})
            except ServerError as error:
                if error.code not in (1004, 1014):
                    raise
        self.count("explosions")

    def forge(self, dice: random.Random) -> None:
        """A snapshot with wrong bytes and the right checksum; a step, when it is taken all the same."""
        with self.trusted() as client:
            plant = client.create(STEADY, seed=1, save=False)
            try:
                text = client.call("simulation.save", {"simulation": plant.identifier, "snapshot": True})["snapshot"]
                content = bytearray(base64.b64decode(text)[:-8])
                for _ in range(10):
                    wrong = bytearray(content)
                    for _ in range(dice.randrange(1, 5)):
                        wrong[dice.randrange(len(wrong))] = dice.choice((0, 1, 0x7f, 0x80, 0xff, dice.randrange(256)))
                    snapshot = base64.b64encode(bytes(wrong) + checksum(wrong)).decode()
                    self.count("forgeries")
                    try:
                        client.call("simulation.restore", {"simulation": plant.identifier, "snapshot": snapshot})
                        self.count("forgeries that were taken")
                        client.call("simulation.step", {"simulation": plant.identifier})
                    except ServerError as error:
                        self.look_for_bug(error, "a snapshot")
            finally:
                client.call("simulation.delete", {"simulation": plant.identifier})

    def open_and_close(self, dice: random.Random) -> None:
        """Many streams: each request is sent without waiting for the answer to the last one."""
        with self.trusted() as client, self.connect("protocol") as peer:
            plant = client.create(STEADY, seed=1, save=False)
            peer.settimeout(SECONDS)
            lines = peer.makefile("rb")
            peer.sendall(HELLO)
            lines.readline()
            for _ in range(20):
                what = dice.choice(("turtle", "string", "geometry"))
                asked = {"jsonrpc": "2.0", "method": "stream.open", "params": {"simulation": plant.identifier, "what": what}}
                peer.sendall(b"".join(json.dumps({**asked, "id": number}).encode() + b"\n" for number in range(2, 102)))
                names: List[str] = []
                refused = 0
                while len(names) + refused < 100:
                    answer = json.loads(lines.readline() or b'{"id": 0, "error": {}}')
                    if "stream" in answer.get("result", {}):
                        names.append(answer["result"]["stream"])
                    elif "id" in answer:
                        refused += 1
                peer.sendall(b"".join(json.dumps({"jsonrpc": "2.0", "id": name, "method": "stream.close",
                                                  "params": {"stream": name}}).encode() + b"\n" for name in names))
                closed = 0
                while closed < len(names):
                    closed += 1 if "id" in json.loads(lines.readline() or b'{"id": 0}') else 0
                with self._lock:
                    self.counts["streams"] = self.counts.get("streams", 0) + len(names)
            client.call("simulation.delete", {"simulation": plant.identifier})

    def reuse(self, dice: random.Random) -> None:
        """Ids that are used twice, answers that nobody asked for, and nothing that is read."""
        with self.connect("protocol") as peer:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            peer.sendall(HELLO)
            request = json.dumps({"jsonrpc": "2.0", "id": 7, "method": dice.choice(("simulation.list", "environment.list"))})
            peer.sendall((request + "\n").encode() * 300)
            peer.sendall(b'{"jsonrpc":"2.0","id":"s1","result":{}}\n' * 100)
            time.sleep(0.1)
        self.count("reused ids")

    def end_half(self, dice: random.Random) -> None:
        """A peer that asks for much and then only reads, or neither sends nor reads."""
        with self.connect("protocol") as peer:
            peer.sendall(HELLO + b'{"jsonrpc":"2.0","id":2,"method":"environment.list"}\n' * 20)
            peer.shutdown(socket.SHUT_WR)
            if dice.random() < 0.5:
                while peer.recv(65_536):
                    pass
        self.count("half open")

    def frame(self, dice: random.Random) -> None:
        """WebSocket frames that are in pieces, wrong, or promise more than there is."""
        def piece(head: int, text: bytes, promised: int = -1) -> bytes:
            size = len(text) if promised < 0 else promised
            length = bytes([0x80 | size]) if size < 126 else b"\xfe" + struct.pack(">H", size) if size < 65_536 \
                else b"\xff" + struct.pack(">Q", size)
            return bytes([head]) + length + bytes(4) + text

        greeting = HELLO.strip()
        wrong = [piece(0x01, b"") + b"".join(piece(0x00, greeting[i:i + 1]) for i in range(len(greeting))) + piece(0x80, b""),
                 piece(0x81, greeting, 2**63 - 1), piece(0x81, b"x", 2**40), piece(0x89, b"p" * 200), piece(0x83, b"reserved"),
                 piece(0xf1, greeting), b"\x81\x05hello", piece(0x80, b"no beginning"), piece(0x81, b"\xff\xfe not text"),
                 piece(0x88, b"\x00"), piece(0x01, b"x" * 60_000) * 3, piece(0x89, b"ping") * 2_000]
        self.count("wrong frames")
        with self.connect("http") as peer:
            peer.settimeout(0.3)
            peer.sendall(UPGRADE)
            peer.recv(65_536)
            if dice.random() < 0.5:
                peer.sendall(piece(0x81, greeting))
                peer.recv(65_536)
            peer.sendall(dice.choice(wrong))
            peer.recv(65_536)

    def ask_oddly(self, dice: random.Random) -> None:
        """Values of every kind where others belong."""
        values: List[Any] = [None, True, -1, 0, 0.5, 2**53, 2**63, 2**64, -2**63, 1e308, -0.0, "", "x" * 70_000, [], {}, [[[]]], {"a": 1},
                  "\x00", "sim-1", [1] * 1_000, "NaN"]
        methods = ("step", "run", "get", "save", "restore", "set", "edit", "reset", "fork", "pause", "delete")
        names = ("steps", "until", "what", "plant", "module", "modules", "action", "seed", "snapshot", "checkpoint", "parameters",
                 "name", "trace", "iterations")
        made: Set[str] = set()
        try:
            with self.trusted() as client:
                plant = client.create(STEADY.replace("1000000", "100"), seed=1, save=False)
                made.add(plant.identifier)
                for _ in range(30):
                    params = {name: dice.choice(values) for name in dice.sample(names, dice.randrange(1, 4))}
                    params["simulation"] = plant.identifier if dice.random() < 0.9 else dice.choice(values)
                    try:
                        answer = client.call("simulation." + dice.choice(methods[:-1]), params)
                        made.add(answer.get("simulation", plant.identifier))
                    except ServerError as error:
                        self.look_for_bug(error, f"{params!r:.300}")
        finally:
            # a long message that the memory has no room for has ended the connection, but not the simulations
            with self.trusted() as client:
                for simulation in made:
                    client.call("simulation.delete", {"simulation": simulation})
        self.count("odd requests")

    def fill(self, dice: random.Random) -> None:
        """Saved simulations until neither the memory nor the disk has room."""
        with self.trusted() as client:
            made = []
            try:
                for seed in range(8):
                    made.append(client.create(NOISE, seed=seed + 8 * dice.randrange(1_000)))
                    made[-1].step(15)
                    self.count("saved")
            except ServerError as error:
                if error.code not in (1004, 1014):
                    raise
                self.count("full")
            finally:
                for plant in made:
                    client.call("simulation.delete", {"simulation": plant.identifier})

    # ---- the machine

    def jump(self, dice: random.Random) -> None:
        """The wall clock goes to another day, year or second."""
        if self.surroundings.clock is not None:
            self.surroundings.clock.write_text(dice.choice(("+0", "+3h", "-2h", "+400d", "-400d", "+20y", "-1")) + "\n",
                                               encoding="ascii")
            self.count("jumps of the clock")
        time.sleep(dice.uniform(0.5, 2.0))

    # ---- the clients that mean well

    def save_well(self, _dice: random.Random) -> None:
        """Steps that are saved; a full disk is told, and the step counts."""
        with self.trusted() as client:
            plant = client.simulation(self.saved) if self.saved else client.create(STEADY, seed=9)
            self.saved = plant.identifier
            while time.monotonic() < self.end and not self.failures:
                try:
                    answer = client.call("simulation.step", {"simulation": plant.identifier})
                    if answer["saved"]:
                        self.saved_step = answer["step"]
                except ServerError as error:
                    if error.code not in (1004, 1014):
                        self.failures.append(f"a saved step: {error}")
                    self.count("steps of the saver that were refused")
                time.sleep(0.01)


def resident_bytes(process_id: int) -> int:
    for line in Path(f"/proc/{process_id}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return 1024 * int(line.split()[1])
    return 0


def problems_at_end(server: Process, hostility: Hostility) -> List[str]:
    """The problems of the server after all that, and of the state that it has kept when it was killed."""
    if server.process.poll() is not None:
        return [f"the server ended with {server.process.poll()}"]
    with Client(hostility.address, timeout=SECONDS, token=TOKEN) as client:
        status = client.status()
    problems = []
    if status["damaged"] != 0 or status["simulations"] > 20:
        problems.append(f"something was left behind: {status}")
    server.process.kill()
    server.process.wait(SECONDS)
    again = hostility.surroundings.serve()
    try:
        with Client(hostility.surroundings.scheme + again.address, timeout=SECONDS, token=TOKEN) as client:
            if not hostility.saved:
                return problems + ["nothing was saved"]
            step = client.call("simulation.get", {"simulation": hostility.saved, "what": "statistics"})["step"]
            if step < hostility.saved_step:
                problems.append(f"step {hostility.saved_step} was answered as saved, and {step} is there")
    finally:
        again.stop()
    return problems


def attack(seconds: float, folder: str, is_encrypted: bool = False) -> List[str]:
    """The problems. Prints the actions, the waiting times, and the memory."""
    surroundings = Surroundings(Path(folder), is_encrypted)
    surroundings.prepare()
    try:
        return attack_in(surroundings, seconds)
    finally:
        surroundings.clean()


def attack_in(surroundings: Surroundings, seconds: float) -> List[str]:
    server = surroundings.serve()
    try:
        http = server._stream.readline().split()[-1]
        hostility = Hostility(surroundings, server.address, http, seconds)
        samples: List[int] = []
        stop = threading.Event()

        def look() -> None:
            while not stop.wait(min(seconds / 100, 5)):
                samples.append(resident_bytes(server.process.pid))

        watcher = threading.Thread(target=look)
        watcher.start()
        hostility.run([hostility.stay_silent, hostility.drip, hostility.drip, hostility.vanish, hostility.flood, hostility.explode,
                       hostility.explode, hostility.forge, hostility.open_and_close, hostility.reuse, hostility.end_half,
                       hostility.frame, hostility.ask_oddly, hostility.fill, hostility.jump, hostility.save_well])
        stop.set()
        watcher.join()
        hostility.failures += problems_at_end(server, hostility)
    finally:
        server.stop()
    report(hostility, seconds, samples)
    return hostility.failures


def report(hostility: Hostility, seconds: float, samples: List[int]) -> None:
    waits = sorted(hostility.waits)
    if not waits:
        hostility.failures.append("the client that means well made no step")
        waits = [float("nan")]
    print(f"{seconds:g} s: " + ", ".join(f"{number} {what}" for what, number in sorted(hostility.counts.items())))
    print(f"{len(waits)} steps of the client that means well: median {1e3 * statistics.median(waits):.1f} ms, "
          f"99 of 100 {1e3 * waits[len(waits) * 99 // 100]:.1f} ms, longest {1e3 * waits[-1]:.0f} ms; "
          f"{hostility.saved_step} saved steps")
    print(f"resident memory: at most {max(samples) / 1e6:.0f} MB, {samples[-1] / 1e6:.0f} MB at the end")
    if max(samples) > 600e6:
        hostility.failures.append("the server has taken more than 600 MB, with a bound of 150 MB")
    third = max(1, len(samples) // 3)
    if seconds >= 300 and max(samples[-third:]) > 1.2 * max(samples[third:2 * third]) + 20e6:
        hostility.failures.append("memory grows")
    missing = {"silent", "slow", "vanished", "floods", "explosions", "forgeries", "streams", "reused ids", "half open",
               "wrong frames", "odd requests", "saved", "pictures"} - set(hostility.counts)
    if missing:
        hostility.failures.append(f"nothing came of: {', '.join(sorted(missing))}")
    if hostility.saved_step == 0:
        hostility.failures.append("no step was saved")
