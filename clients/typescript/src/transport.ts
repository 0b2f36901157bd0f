import { ConnectionLost } from "./errors.js";
import { decodeFrame, encodeFrame } from "./wire.js";
import type { Message, OutgoingBlock } from "./wire.js";

/** Carries messages to a peer and back. */
export interface Transport {
  /** Set by the connection before anything is sent. */
  onMessage: (message: Message) => void;
  onClose: () => void;
  send(message: Message, blocks?: OutgoingBlock[]): void;
  close(): void;
}

/** Opens a transport. The promise fails when the peer cannot be reached. */
export type Dial = () => Promise<Transport>;

const PATH = "/espalier/1";

/** The address of a server's WebSocket: `ws://HOST:PORT`, also `http://…`; the path may be left out. */
export function webSocketAddress(address: string): string {
  const url = new URL(address.replace(/^http/, "ws"));
  if (url.pathname === "/" || url.pathname === "") {
    url.pathname = PATH;
  }
  url.hash = "";
  return url.href;
}

/** Connects over a WebSocket of the browser, or of a Node.js that has one (22 or newer). */
export async function dialWebSocket(address: string): Promise<Transport> {
  if (typeof WebSocket === "undefined") {
    throw new Error("This Node.js has no WebSocket. Connect to the server's TCP address instead: tcp://HOST:PORT.");
  }
  const socket = new WebSocket(webSocketAddress(address));
  socket.binaryType = "arraybuffer";
  await new Promise<void>((opened, failed) => {
    socket.onopen = () => opened();
    socket.onclose = socket.onerror = () =>
      failed(new ConnectionLost(`The server at ${socket.url} cannot be reached. Is it running, with --http?`));
  });
  const transport: Transport = {
    onMessage: () => {},
    onClose: () => {},
    send: (message, blocks) => socket.send(encodeFrame(message, blocks)),
    close: () => socket.close(),
  };
  socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => transport.onMessage(decodeFrame(event.data));
  socket.onerror = null;
  socket.onclose = () => transport.onClose();
  return transport;
}
