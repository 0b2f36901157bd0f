"""The client for asyncio against the real server: the methods of the blocking one, streams and many calls at once."""

import asyncio
import inspect
import unittest
from typing import List

from support import GALLERY, SECONDS, program, strings

from espalier import (AsyncClient, AsyncSimulation, AsyncStream, Client, ConnectionLost, EspalierError, Server, ServerError,
                      Simulation, Stream)

# never finished before somebody ends it
ENDLESS = "Lsystem: 1\nderivation length: 1000000\nAxiom: A\nA --> A\nendlsystem\n"


class AsyncClientAndServer(unittest.IsolatedAsyncioTestCase):
    server: Server

    @classmethod
    def setUpClass(cls) -> None:
        cls.server = Server(program(), arguments=["--gallery", str(GALLERY), "--http", "127.0.0.1:0", "--log-level", "off"])
        assert cls.server._process.stdout is not None
        cls.http = cls.server._process.stdout.readline().decode().strip().split("http on ")[1]

    @classmethod
    def tearDownClass(cls) -> None:
        cls.server.stop()

    async def asyncSetUp(self) -> None:
        self.client = await AsyncClient(self.server.address, timeout=SECONDS).connect()
        self.addAsyncCleanup(self.client.close)

    async def test_has_the_methods_of_the_blocking_client(self) -> None:
        only_blocking = {"over", "view", "plot", "save_to"}
        for blocking, waiting in ((Client, AsyncClient), (Simulation, AsyncSimulation), (Stream, AsyncStream)):
            for name, method in inspect.getmembers(blocking, inspect.isfunction):
                if not name.startswith("_") and name not in only_blocking:
                    twin = getattr(waiting, name)
                    self.assertEqual(str(inspect.signature(twin)).replace("Async", "").replace("'", ""),
                                     str(inspect.signature(method)).replace("'", ""), name)
                    self.assertTrue(twin.__doc__ and ">>>" not in twin.__doc__, name)

    async def test_steps_and_reads_like_the_blocking_client(self) -> None:
        self.assertTrue((await self.client.load(gallery="classic-algae")).valid)
        self.assertFalse((await self.client.check("Lsystem: 1\nAxiom: A(\n")).valid)
        algae = await self.client.create(gallery="classic-algae", derivation_length=6)
        start = await algae.save()
        self.assertEqual([made.step async for made in algae.steps()], [1, 2, 3, 4, 5, 6])
        self.assertEqual(await algae.string(), strings("classic-algae")[6])
        other = await algae.fork()
        await algae.prune(2)
        self.assertEqual(len(await algae.string()), 2)
        await algae.insert(0, ["b"])
        await algae.replace(0, ["a", "a"])
        self.assertEqual(await algae.string(), "aaab")
        await algae.restore(start)
        self.assertEqual(await algae.string(), "a")
        self.assertEqual(await other.string(), strings("classic-algae")[6])
        await other.reset()
        self.assertEqual((await other.get("information"))["information"]["step"], 0)
        self.assertEqual(len(await other.turtle()), 1)
        self.assertEqual((await other.geometry())[:4], b"glTF")
        self.assertIn("classic-algae", await self.client.gallery())
        found = await self.client.simulation(other.identifier)
        await found.delete()
        self.assertNotIn(other.identifier, [item["simulation"] for item in await self.client.simulations()])
        self.assertIn("honda", [process["name"] for process in await self.client.environments()])
        self.assertIn("server", await self.client.status())

    async def test_a_call_is_cancelled_after_its_seconds(self) -> None:
        endless = await self.client.create(ENDLESS)
        with self.assertRaises(ServerError) as caught:
            await self.client.call("simulation.run", {"simulation": endless.identifier, "steps": 1_000_000}, seconds=0.2)
        self.assertEqual(caught.exception.code, 1010)
        self.assertIn("server", await self.client.call("server.status", seconds=30))
        await endless.delete()

    async def test_streams_while_the_simulation_runs(self) -> None:
        tiers = await self.client.create(gallery="branch-tiers", environment=[{"type": "honda", "radius": 0.5}], seed=7)
        async with await tiers.stream("turtle", arrays=True) as stream:
            running = asyncio.ensure_future(tiers.run())
            steps, missed, last = [], 0, 0
            async for frame in stream:
                steps.append(frame.step)
                missed += frame.missed
                last = frame.count
            made = await running
        self.assertEqual(steps, sorted(set(steps)))
        self.assertEqual((steps[0], steps[-1]), (0, made.step))
        self.assertEqual(len(steps) + missed, made.step + 1)
        self.assertEqual(last, len(await tiers.turtle()))
        with self.assertRaisesRegex(EspalierError, "The stream is closed."):
            await stream.read()

    async def test_run_reports_its_progress(self) -> None:
        algae = await self.client.create(gallery="classic-algae", derivation_length=12)
        seen: List[int] = []
        made = await algae.run(lambda frame: seen.append(frame.step))
        self.assertEqual((made.step, seen[-1]), (12, 12))
        self.assertEqual(seen, sorted(set(seen)))

        def stop(frame: object) -> None:
            raise KeyError("enough")

        with self.assertRaisesRegex(KeyError, "enough"):
            endless = await self.client.create(ENDLESS, save=False)
            await endless.run(stop)
        # nothing runs it any more: a step behind an endless run would wait for ever
        self.assertGreater((await endless.step()).step, 0)

    async def test_a_cancelled_task_cancels_the_call_on_the_server(self) -> None:
        endless = await self.client.create(ENDLESS, save=False)
        async with await endless.stream("statistics") as stream:
            running = asyncio.ensure_future(endless.run())
            while (await stream.read(SECONDS)).step == 0:
                pass
            running.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await running
        # a step behind an endless run would wait for ever
        self.assertGreater((await endless.step()).step, 1)
        self.assertEqual(await endless.pause(), 0)

    async def test_many_calls_are_under_way_at_once(self) -> None:
        async def grow(length: int) -> str:
            algae = await self.client.create(gallery="classic-algae", derivation_length=length)
            await algae.run()
            return await algae.string()

        grown = await asyncio.gather(*(grow(length) for length in range(1, 9)))
        self.assertEqual(grown, strings("classic-algae")[1:9])

    async def test_speaks_over_a_websocket(self) -> None:
        async with AsyncClient(f"ws://{self.http}", timeout=SECONDS) as client:
            algae = await client.create(gallery="classic-algae")
            async with await algae.stream("turtle", arrays=True) as stream:
                self.assertEqual((await stream.read(SECONDS)).count, 1)

    async def test_says_what_went_wrong(self) -> None:
        with self.assertRaises(ServerError) as caught:
            await self.client.simulation("sim-nowhere")
        self.assertEqual(caught.exception.code, 1011)
        with self.assertRaisesRegex(ConnectionLost, "Nothing answers at 127.0.0.1:1 .*espalier serve"):
            await AsyncClient("127.0.0.1:1").connect()
        with self.assertRaisesRegex(ConnectionLost, "Nothing answers at unix:/nowhere"):
            await AsyncClient("unix:/nowhere").connect()
        with self.assertRaisesRegex(EspalierError, "The client is not connected. Use `async with"):
            await AsyncClient(self.server.address).status()
        with self.assertRaisesRegex(ConnectionLost, "does not open a WebSocket"):
            await self._upgrade_refused()

    async def _upgrade_refused(self) -> None:
        async def refuse(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await reader.readuntil(b"\r\n\r\n")
            writer.write(b"HTTP/1.1 404 Not Found\r\n\r\n")
            writer.close()

        listener = await asyncio.start_server(refuse, "127.0.0.1", 0)
        async with listener:
            await AsyncClient(f"ws://127.0.0.1:{listener.sockets[0].getsockname()[1]}").connect()

    async def test_everybody_who_waits_learns_that_the_connection_is_lost(self) -> None:
        server = Server(program(), arguments=["--log-level", "off"])
        self.addCleanup(server.stop)
        client = await AsyncClient(server.address).connect()
        self.addAsyncCleanup(client.close)
        endless = await client.create(ENDLESS, save=False)
        stream = await endless.stream("string", credits=1)
        await stream.read(SECONDS)
        reading = asyncio.ensure_future(stream.read())
        running = asyncio.ensure_future(endless.run())
        server._process.kill()
        for waiting in (reading, running):
            with self.assertRaisesRegex(ConnectionLost, "closed the connection|is lost"):
                while True:
                    await asyncio.wait_for(waiting, SECONDS)
                    waiting = asyncio.ensure_future(stream.read())
        with self.assertRaises(ConnectionLost):
            await client.status()


if __name__ == "__main__":
    unittest.main()
