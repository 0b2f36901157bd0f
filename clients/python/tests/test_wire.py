"""The codec: messages as lines."""

import io
import math
import socket
import struct
import unittest
from array import array

from espalier import wire
from espalier.errors import ConnectionLost, ProtocolError
from espalier.requests import result_of
from espalier.websocket import Frames


class Codec(unittest.TestCase):
    def test_numbers_keep_all_their_bits(self) -> None:
        numbers = [0.1, 1 / 3, 1e-310, -0.0, 2.0**53, 5e-324, 1.7976931348623157e308]
        read = wire.decode(wire.encode({"numbers": numbers}))["numbers"]
        self.assertEqual([number.hex() for number in numbers], [float(number).hex() for number in read])

    def test_a_message_is_one_line_of_utf8(self) -> None:
        line = wire.encode({"name": "Bäume\nund Blätter"})
        self.assertEqual(line.count(b"\n"), 1)
        self.assertTrue(line.endswith(b"\n"))
        self.assertEqual(wire.decode(line), {"name": "Bäume\nund Blätter"})

    def test_numbers_that_are_not_finite_are_refused_both_ways(self) -> None:
        for number in (math.nan, math.inf, -math.inf):
            with self.assertRaisesRegex(ProtocolError, "not finite"):
                wire.encode({"number": number})
        for text in (b"NaN", b"Infinity", b"-Infinity"):
            with self.assertRaisesRegex(ProtocolError, "not a finite number"):
                wire.decode(b'{"number":' + text + b"}")

    def test_half_of_a_character_pair_is_escaped(self) -> None:
        line = wire.encode({"name": "\ud800 ü"})
        self.assertEqual(line.decode("utf-8"), '{"name":"\\ud800 ü"}\n')
        self.assertEqual(wire.decode(line), {"name": "\ud800 ü"})

    def test_a_wrong_answer_is_named(self) -> None:
        with self.assertRaisesRegex(ProtocolError, "the answer to hello, found a list"):
            wire.has_blocks([])  # type: ignore[arg-type]
        with self.assertRaisesRegex(ProtocolError, "error.code: expected a whole number"):
            result_of(wire.Received({"id": 1, "error": {"code": "x"}}))

    def test_anything_but_an_object_is_refused(self) -> None:
        with self.assertRaisesRegex(ProtocolError, "Expected a JSON object on a line"):
            wire.decode(b"[" * 100_000)
        with self.assertRaisesRegex(ProtocolError, "found a list"):
            wire.decode(b"[1]")
        with self.assertRaisesRegex(ProtocolError, "Expected a JSON object on a line, found 'GET / HTTP/1.1'"):
            wire.decode(b"GET / HTTP/1.1")

    def test_addresses(self) -> None:
        self.assertEqual(wire.parse_address("127.0.0.1:4321"), ("127.0.0.1", 4321))
        self.assertEqual(wire.parse_address("tcp://[::1]:9"), ("::1", 9))
        self.assertEqual(wire.parse_address("4321"), ("127.0.0.1", 4321))
        for wrong in ("localhost", "host:", "host:70000", ""):
            with self.assertRaisesRegex(ProtocolError, "Expected HOST:PORT"):
                wire.parse_address(wrong)


class WebSockets(unittest.TestCase):
    def test_raw_bytes_begin_at_the_next_multiple_of_eight_for_every_length_of_the_json(self) -> None:
        paddings = set()
        for extra in range(8):
            frames = Frames("peer")
            sent = frames.encoded({"text": "x" * (100 + extra)}, {"a": array("d", [1.5, -2.0])})
            kind, size, mask = sent[0] & 15, struct.unpack_from(">H", sent, 2)[0], sent[4:8]
            self.assertEqual((kind, sent[1], len(sent)), (2, 0x80 | 126, 8 + size))
            data = bytes(byte ^ mask[i % 4] for i, byte in enumerate(sent[8:]))
            length = struct.unpack_from("<I", data)[0]
            begin = (4 + length + 7) // 8 * 8
            paddings.add(begin - 4 - length)
            self.assertEqual(data[4 + length:], bytes(begin - 4 - length) + struct.pack("<2d", 1.5, -2.0))
            # the way back: from a server, which masks nothing
            reading = frames.message(True)
            stream = io.BytesIO(bytes([0x82, 126]) + struct.pack(">H", size) + data)
            asked = next(reading)
            with self.assertRaises(StopIteration) as end:
                while isinstance(asked, int):
                    asked = reading.send(stream.read(asked))
            self.assertEqual(list(end.exception.value.blocks["a"]), [1.5, -2.0])
        self.assertEqual(paddings, set(range(8)))


class Sockets(unittest.TestCase):
    def setUp(self) -> None:
        near, self.far = socket.socketpair()
        self.channel = wire.SocketChannel(near, "peer")
        self.addCleanup(self.far.close)
        self.addCleanup(self.channel.close)

    def test_lines_arrive_in_whatever_pieces(self) -> None:
        self.far.sendall(b'{"a":1}\n{"b"')
        self.assertEqual(self.channel.receive(5), {"a": 1})
        self.far.sendall(b":2}\n")
        self.assertEqual(self.channel.receive(5), {"b": 2})

    def test_the_end_of_the_stream_is_nothing(self) -> None:
        self.far.close()
        self.assertIsNone(self.channel.receive(5))

    def test_waiting_ends_in_a_timeout_and_loses_nothing(self) -> None:
        self.far.sendall(b'{"a"')
        with self.assertRaises(TimeoutError):
            self.channel.receive(0.01)
        self.far.sendall(b":1}\n")
        self.assertEqual(self.channel.receive(5), {"a": 1})

    def test_nobody_there_says_how_to_start_a_server(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as listener:
            port = listener.getsockname()[1]
        with self.assertRaisesRegex(ConnectionLost, f"Nothing answers at 127.0.0.1:{port} .*espalier serve --listen"):
            wire.SocketChannel.connect("127.0.0.1", port, 5)


if __name__ == "__main__":
    unittest.main()
