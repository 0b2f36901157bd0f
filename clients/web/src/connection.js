// A connection to the server of this page: JSON-RPC over a WebSocket, with binary arrays after a message.

const READERS = { "<f8": Float64Array, "<f4": Float32Array, "<u4": Uint32Array };

/** An error that the server answered: code, message, data. */
export class ServerError extends Error {
  constructor(error) {
    super(error.message);
    this.code = error.code;
    this.data = error.data;
  }
}

// the message of a binary frame: length of the JSON, the JSON, zeros up to a multiple of 8, the blocks
function readBinary(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const message = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const begin = 4 + length + ((8 - ((4 + length) % 8)) % 8);
  message.blocks = {};
  for (const { name, dtype, offset, bytes } of message.bin ?? []) {
    const Kind = READERS[dtype];
    message.blocks[name] = new Kind(buffer, begin + offset, bytes / Kind.BYTES_PER_ELEMENT);
  }
  return message;
}

export class Connection {
  /** Connects and sends hello. Calls `onNotification(method, params, blocks)`, and `onClosed()` when the connection is lost. */
  static async open(address, token, onNotification, onClosed) {
    const connection = new Connection();
    connection.waiting = new Map();
    connection.lastId = 0;
    connection.onNotification = onNotification;
    connection.socket = new WebSocket(address);
    connection.socket.binaryType = "arraybuffer";
    await new Promise((opened, failed) => {
      connection.socket.onopen = opened;
      connection.socket.onerror = () => failed(new Error("The server cannot be reached."));
    });
    connection.socket.onmessage = (event) => connection.take(event.data);
    connection.socket.onclose = () => {
      for (const { failed } of connection.waiting.values()) {
        failed(new Error("The connection to the server is lost."));
      }
      connection.waiting.clear();
      if (connection.server) {
        onClosed();
      }
    };
    const hello = { protocol: [1], roles: ["controller", "viewer"], name: "page", version: "1", capabilities: ["bin", "strict"] };
    connection.server = await connection.call("hello", token ? { ...hello, token } : hello);
    return connection;
  }

  call(method, params = {}) {
    const id = ++this.lastId;
    return new Promise((done, failed) => {
      this.waiting.set(id, { done, failed });
      this.socket.send(JSON.stringify({ jsonrpc: "2.0", id, method, params }));
    });
  }

  notify(method, params) {
    this.socket.send(JSON.stringify({ jsonrpc: "2.0", method, params }));
  }

  take(data) {
    const message = typeof data === "string" ? JSON.parse(data) : readBinary(data);
    if (message.method) {
      this.onNotification(message.method, message.params, message.blocks ?? {});
      return;
    }
    const waiting = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    if (message.error) {
      waiting?.failed(new ServerError(message.error));
    } else {
      waiting?.done(message.result);
    }
  }

  close() {
    this.socket.onclose = null;
    this.socket.close();
  }
}
