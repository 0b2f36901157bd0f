// Transports that only Node.js has: TCP, TLS, Unix sockets, standard input and output.
import { createConnection } from "node:net";
import { connect as connectTls } from "node:tls";
import type { Readable, Writable } from "node:stream";
import { ConnectionLost } from "./errors.js";
import { LineReader, encodeLine } from "./wire.js";
import type { Transport } from "./transport.js";

/** Lines over a pair of streams. */
export function lineTransport(input: Readable, output: Writable, end: () => void): Transport {
  const reader = new LineReader();
  const transport: Transport = {
    onMessage: () => {},
    onClose: () => {},
    send: (message, blocks) => void output.write(encodeLine(message, blocks)),
    close: end,
  };
  input.on("data", (chunk: Uint8Array) => {
    for (const message of reader.push(chunk)) {
      transport.onMessage(message);
    }
  });
  input.on("close", () => transport.onClose());
  output.on("error", () => end());
  return transport;
}

/** Connects to `tcp://HOST:PORT`, `tls://HOST:PORT`, `HOST:PORT` or `unix:PATH`. */
export async function dialTcp(address: string, certificateAuthority?: string): Promise<Transport> {
  const isEncrypted = address.startsWith("tls://");
  const path = address.startsWith("unix:") ? address.slice(5) : undefined;
  const { hostname, port } = path ? { hostname: "", port: "" } : new URL(`tcp://${address.replace(/^(tcp|tls):\/\//, "")}`);
  const host = hostname.replace(/^\[|\]$/g, "");
  const socket = path
    ? createConnection({ path })
    : isEncrypted
      ? connectTls({ host, port: Number(port), servername: host, ...(certificateAuthority ? { ca: certificateAuthority } : {}) })
      : createConnection({ host, port: Number(port), noDelay: true });
  await new Promise<void>((opened, failed) => {
    socket.once(isEncrypted ? "secureConnect" : "connect", () => opened());
    socket.once("error", (error) => failed(new ConnectionLost(`The server at ${address} cannot be reached: ${error.message}.`)));
  });
  socket.on("error", () => socket.destroy());
  return lineTransport(socket, socket, () => socket.destroy());
}
