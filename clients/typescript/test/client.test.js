// The client in Node.js against a real server. ESPALIER_PROGRAM names the program.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { ConnectionLost, ServerError, connect } from "../dist/node.js";
import { decodeFrame, encodeFrame } from "../dist/wire.js";

const here = dirname(fileURLToPath(import.meta.url));
const program = process.env.ESPALIER_PROGRAM;
const gallery = join(here, "../../gallery");
// growth at every tip and within, organs that disappear, chance
const GROWING = `Lsystem: 1
derivation length: 400
Axiom: F(1)A(0)
A(x) : x < 9 --> F(1)[+(ran(90))B(0)]A(x+1)
A(x) : x >= 9 --> F(0.5)A(x-9)
B(x) : x > 5 --> *
B(x) --> F(ran(1))[-(50)C(x)]?E(x)B(x+1)
C(x) : x > 2 --> *
C(x) --> F(0.1){.f(1)-(90).f(1).}C(x+1)
endlsystem
`;

/** Starts a server and returns the process and its addresses. */
function serve(listen = "127.0.0.1:0", ...more) {
  const server = spawn(program, ["serve", "--listen", listen, "--http", "127.0.0.1:0", "--gallery", gallery, "--log-level", "off", ...more]);
  return new Promise((ready) => {
    let text = "";
    server.stdout.on("data", (chunk) => {
      text += chunk;
      const found = /listening on (\S+)\n[^]*http on (\S+)\n/.exec(text);
      if (found) {
        ready({ server, address: found[1], http: found[2] });
      }
    });
  });
}

const ended = (child) => new Promise((done) => (child.exitCode === null ? child.once("exit", done) : done()));

let running;
let client;
before(async () => {
  running = await serve();
  client = await connect(running.address);
});
after(async () => {
  client.close();
  running.server.kill();
  await ended(running.server);
});

function tableOf(geometry) {
  const segments = Object.fromEntries(["Plant", "Module", "Symbol", "Order", "Start", "End", "EndWidth"].map((name) => [name, [...geometry.segments.column(name)]]));
  const organs = Object.fromEntries(["Plant", "Module", "Kind", "Vertices", "Triangles"].map((name) => [name, [...geometry.organs.column(name)]]));
  return { segments, organs, vertices: [...geometry.vertices.column("Position")], triangles: [...geometry.triangles.column("Corners")] };
}

test("raw bytes begin at the next multiple of eight for every length of the text", () => {
  const paddings = new Set();
  for (let extra = 0; extra < 8; extra += 1) {
    const message = { jsonrpc: "2.0", method: "m", params: { text: "x".repeat(extra) } };
    const frame = encodeFrame(message, [{ name: "a", values: new Float64Array([1.5, -2]) }]);
    const end = 4 + new DataView(frame.buffer).getUint32(0, true);
    const begin = Math.ceil(end / 8) * 8;
    paddings.add(begin - end);
    assert.deepEqual([...frame.subarray(end)], [...new Uint8Array(begin - end), ...new Uint8Array(new Float64Array([1.5, -2]).buffer)]);
    assert.deepEqual([...decodeFrame(frame.buffer).blocks.a], [1.5, -2]);
  }
  assert.equal(paddings.size, 8);
});

test("a viewer of differences holds what a viewer of whole frames holds", async () => {
  const simulation = await client.create({ model: { source: GROWING }, seed: 7, environment: [{ type: "honda", radius: 0.1 }] });
  const viewer = await connect(running.address);
  const columns = (await viewer.stream("columns", simulation.id))[Symbol.asyncIterator]();
  const strings = (await viewer.stream("string", simulation.id))[Symbol.asyncIterator]();
  const records = (await viewer.stream("turtle", simulation.id))[Symbol.asyncIterator]();
  let differences = 0;
  for (let step = 0; step <= 12; ++step) {
    if (step > 0) {
      await simulation.step();
    }
    const shown = (await columns.next()).value;
    assert.equal(shown.step, step);
    differences += shown.change.isWhole ? 0 : 1;
    // a stream that opens now begins with everything
    const whole = (await viewer.stream("columns", simulation.id))[Symbol.asyncIterator]();
    assert.deepEqual(tableOf(shown.geometry), tableOf((await whole.next()).value.geometry), `step ${step}`);
    await whole.return();
    assert.equal((await strings.next()).value.string, await simulation.string());
    const { turtle } = (await records.next()).value;
    const wanted = (await simulation.get("turtle")).records;
    assert.equal(turtle.count, wanted.length);
    wanted.forEach((record, i) => {
      assert.equal(turtle.module[i], record.module);
      assert.equal(turtle.parent[i], record.parent ?? 0xffffffff);
      assert.deepEqual([...turtle.position.slice(3 * i, 3 * i + 3)], record.position);
      assert.deepEqual([...turtle.parameters.slice(turtle.parameterOffset[i], turtle.parameterOffset[i + 1])], record.parameters);
    });
  }
  assert.ok(differences > 6, `only ${differences} frames of 13 were differences`);
  viewer.close();
});

test("streams that are opened at the same time all get their first frames", async () => {
  const simulation = await client.create({ model: { source: GROWING }, seed: 7, environment: [{ type: "honda", radius: 0.1 }] });
  for (let i = 0; i < 20; ++i) {
    const streams = await Promise.all(["statistics", "string", "columns", "statistics"].map((kind) => client.stream(kind, simulation.id)));
    const first = Promise.all(streams.map((stream) => stream[Symbol.asyncIterator]().next()));
    const late = new Promise((_, failed) => setTimeout(failed, 10_000, new Error("a first frame is missing")).unref());
    assert.deepEqual((await Promise.race([first, late])).map(({ value }) => value.sequence), [0, 0, 0, 0]);
    await Promise.all(streams.map((stream) => stream.close()));
  }
});

test("frames of a stream with credits are acknowledged one by one, and those of a stream without credits are not", async () => {
  const simulation = await client.create({ model: { source: GROWING }, seed: 1, environment: [{ type: "honda", radius: 0.1 }] });
  const acknowledged = async (options) => {
    const stream = await simulation.stream("statistics", options);
    let count = 0;
    const { connection } = stream;
    const notify = connection.notify.bind(connection);
    connection.notify = (method, params) => (count += method === "stream.ack" ? 1 : 0, notify(method, params));
    await simulation.reset(1);
    const stepping = simulation.step(3);
    for await (const { step } of stream) {
      if (step === 3) {
        break;
      }
    }
    await stepping;
    connection.notify = notify;
    return count;
  };
  assert.ok((await acknowledged({ credits: 1 })) > 0);
  assert.equal(await acknowledged({ credits: undefined }), 0);
  await simulation.delete();
});

test("an environment in TypeScript grows the same plant as one in Python's protocol example", async () => {
  const peer = await connect(running.address, { roles: ["environment"] });
  const seen = [];
  await peer.offer("ceiling", {
    describe: () => ({ name: "ceiling", needs: ["position", "following"], outputs: [{ name: "light", unit: "1" }] }),
    step({ queries, step, note }) {
      seen.push([step, queries.length, queries[0]?.position?.length]);
      note("the sky is clear");
      return queries.map((query) => (query.position[1] < 6 ? 1 : 0));
    },
  });
  const simulation = await client.create({ model: { gallery: "light-tree" }, seed: 7, environment: [{ type: "offered", name: "ceiling" }] });
  const { warnings } = await simulation.run();
  assert.deepEqual(warnings, ["the sky is clear"]);
  const grown = await simulation.string();
  const script = join(mkdtempSync(join(tmpdir(), "espalier-")), "ceiling.mjs");
  writeFileSync(script, `import { serveStdio } from ${JSON.stringify(join(here, "../dist/node.js"))};
await serveStdio({ step: ({ queries, note }) => (note("dusk"), queries.map((query) => [query.position[1] < 6 ? 1 : 0])) }, "ceiling");\n`);
  const alone = spawnSync(program, ["derive", join(gallery, "light-tree"), "--seed", "7", "--environment", `stdio:node ${script}`], { encoding: "utf8" });
  rmSync(dirname(script), { recursive: true });
  assert.equal(alone.stdout.trim(), grown, alone.stderr);
  assert.deepEqual(alone.stderr.match(/dusk/g), ["dusk"]);
  assert.ok(seen.length > 3 && seen.some(([, queries, length]) => queries > 1 && length === 3));
  peer.close();
});

test("errors are values with their codes, and a long request can be given up", async () => {
  await assert.rejects(client.create({ model: { source: "Lsystem: 1\nAxiom: A(\nendlsystem\n" } }), (error) => {
    assert.ok(error instanceof ServerError);
    assert.equal(error.code, 1009);
    assert.match(error.data.diagnostics[0].text, /:2:\d+: error/);
    return true;
  });
  const endless = await client.create({ model: { source: "Lsystem: 1\nderivation length: 1000000000\nAxiom: A\nA --> A\nendlsystem\n" } });
  const giveUp = new AbortController();
  const progress = [];
  const call = endless.run({ signal: giveUp.signal, onProgress: (p) => (progress.push(p.step), giveUp.abort()) });
  await assert.rejects(call, { code: 1010 });
  assert.ok(progress.length >= 1);
  await endless.delete();
});

test("a client connects again by itself, and its streams go on", async () => {
  const data = mkdtempSync(join(tmpdir(), "espalier-"));
  const first = await serve("127.0.0.1:0", "--data", data);
  let connected;
  const again = new Promise((done) => (connected = done));
  const states = [];
  const peer = await connect(first.address, { onConnection: (is) => (states.push(is), is && connected()) });
  const simulation = await peer.create({ model: { source: GROWING }, seed: 3 });
  await simulation.step(4);
  const frames = (await simulation.stream("columns"))[Symbol.asyncIterator]();
  const before = tableOf((await frames.next()).value.geometry);
  first.server.kill("SIGKILL");
  await ended(first.server);
  await assert.rejects(peer.gallery(), ConnectionLost);
  const second = await serve(first.address, "--data", data);
  await again;
  const frame = (await frames.next()).value;
  assert.equal(frame.step, 4);
  assert.deepEqual(tableOf(frame.geometry), before);
  assert.deepEqual(states, [false, true]);
  peer.close();
  second.server.kill();
  await ended(second.server);
  rmSync(data, { recursive: true });
});

test("a connection that the server ends tells why", async () => {
  const { server, address } = await serve("127.0.0.1:0", "--limit", "lineBytes=100000");
  const peer = await connect(address, { reconnect: false });
  await assert.rejects(peer.create({ model: { source: "x".repeat(200_000) } }), (error) => {
    assert.ok(error instanceof ConnectionLost);
    assert.match(error.message, /lost: the limit 'lineBytes' is 100000/);
    return true;
  });
  await assert.rejects(peer.gallery(), /closed: the limit 'lineBytes' is 100000/);
  peer.close();
  server.kill();
  await ended(server);
});

test("the types know every method of the protocol", async () => {
  const methods = readFileSync(join(here, "../../../protocol/methods.def"), "utf8").matchAll(/^ESPALIER_\w+\("([^"]+)"/gm);
  const types = readFileSync(join(here, "../src/protocol.ts"), "utf8");
  for (const [, name] of methods) {
    assert.ok(types.includes(`  "${name}": {`), name);
  }
});
