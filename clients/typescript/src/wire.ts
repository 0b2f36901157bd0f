// Messages as bytes: JSON with blocks of numbers behind it, in one WebSocket frame or after one line.

export type Column = Float64Array | Float32Array | Uint32Array;
export type Columns = Record<string, Column>;

/** A JSON-RPC message; `blocks` has its binary columns, flat. */
export interface Message {
  jsonrpc: "2.0";
  id?: number | string | null;
  method?: string;
  params?: any;
  result?: any;
  error?: { code: number; message: string; data?: Record<string, unknown> };
  bin?: BlockEntry[];
  binBytes?: number;
  blocks?: Columns;
}

interface BlockEntry {
  name: string;
  dtype: "<f8" | "<f4" | "<u4";
  shape: number[];
  offset: number;
  bytes: number;
}

/** A column to send; `width` numbers make a row. */
export interface OutgoingBlock {
  name: string;
  values: Column;
  width?: number;
}

const KINDS = { "<f8": Float64Array, "<f4": Float32Array, "<u4": Uint32Array } as const;
const encoder = new TextEncoder();
const decoder = new TextDecoder();

const padding = (length: number): number => (8 - (length % 8)) % 8;

function columnsOf(entries: BlockEntry[], buffer: ArrayBuffer, begin: number): Columns {
  const columns: Columns = {};
  for (const { name, dtype, offset, bytes } of entries) {
    const Kind = KINDS[dtype];
    columns[name] = new Kind(buffer, begin + offset, bytes / Kind.BYTES_PER_ELEMENT);
  }
  return columns;
}

function dtypeOf(values: Column): BlockEntry["dtype"] {
  return values instanceof Float64Array ? "<f8" : values instanceof Float32Array ? "<f4" : "<u4";
}

/** The text of a message and its blocks as bytes; no blocks: only the text. */
function pack(message: Message, blocks: OutgoingBlock[]): { text: string; bytes: Uint8Array } {
  const { blocks: _, ...plain } = message;
  if (blocks.length === 0) {
    return { text: JSON.stringify(plain), bytes: new Uint8Array(0) };
  }
  let offset = 0;
  const bin = blocks.map(({ name, values, width }) => {
    const shape = width === undefined ? [values.length] : [values.length / width, width];
    const entry: BlockEntry = { name, dtype: dtypeOf(values), shape, offset, bytes: values.byteLength };
    offset += values.byteLength + padding(values.byteLength);
    return entry;
  });
  const bytes = new Uint8Array(offset);
  blocks.forEach(({ values }, i) => bytes.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), bin[i].offset));
  return { text: JSON.stringify({ ...plain, bin, binBytes: offset }), bytes };
}

/** A message for a WebSocket: a text, or the bytes of a binary frame. */
export function encodeFrame(message: Message, blocks: OutgoingBlock[] = []): string | Uint8Array<ArrayBuffer> {
  const { text, bytes } = pack(message, blocks);
  if (blocks.length === 0) {
    return text;
  }
  const json = encoder.encode(text);
  const begin = 4 + json.length + padding(4 + json.length);
  const frame = new Uint8Array(begin + bytes.length);
  new DataView(frame.buffer).setUint32(0, json.length, true);
  frame.set(json, 4);
  frame.set(bytes, begin);
  return frame;
}

/** The message of a WebSocket frame. */
export function decodeFrame(data: string | ArrayBuffer): Message {
  if (typeof data === "string") {
    return JSON.parse(data) as Message;
  }
  const length = new DataView(data).getUint32(0, true);
  const message = JSON.parse(decoder.decode(new Uint8Array(data, 4, length))) as Message;
  message.blocks = columnsOf(message.bin ?? [], data, 4 + length + padding(4 + length));
  return message;
}

/** A message as one line with its blocks behind it. */
export function encodeLine(message: Message, blocks: OutgoingBlock[] = []): Uint8Array {
  const { text, bytes } = pack(message, blocks);
  const line = encoder.encode(`${text}\n`);
  const whole = new Uint8Array(line.length + bytes.length);
  whole.set(line);
  whole.set(bytes, line.length);
  return whole;
}

/** Cuts a stream of bytes into messages. */
export class LineReader {
  private chunks: Uint8Array[] = [];
  private length = 0;
  private waiting: Message | null = null; // its blocks have not come yet

  /** Takes bytes and returns the messages that are complete with them. */
  push(chunk: Uint8Array): Message[] {
    // without an end of a line there is nothing to look at
    this.chunks.push(chunk);
    this.length += chunk.length;
    if (this.waiting ? this.length < (this.waiting.binBytes ?? 0) : !chunk.includes(10)) {
      return [];
    }
    let rest = this.joined();
    const messages: Message[] = [];
    for (;;) {
      if (this.waiting) {
        const bytes = this.waiting.binBytes ?? 0;
        if (rest.length < bytes) {
          break;
        }
        // a copy begins at an aligned address
        this.waiting.blocks = columnsOf(this.waiting.bin ?? [], new Uint8Array(rest.subarray(0, bytes)).buffer, 0);
        messages.push(this.waiting);
        this.waiting = null;
        rest = rest.subarray(bytes);
      }
      const end = rest.indexOf(10);
      if (end < 0) {
        break;
      }
      const line = decoder.decode(rest.subarray(0, end)).trim();
      rest = rest.subarray(end + 1);
      if (line !== "") {
        const message = JSON.parse(line) as Message;
        if (message.binBytes) {
          this.waiting = message;
        } else {
          messages.push(message);
        }
      }
    }
    this.chunks = rest.length > 0 ? [rest] : [];
    this.length = rest.length;
    return messages;
  }

  private joined(): Uint8Array {
    if (this.chunks.length === 1) {
      return this.chunks[0];
    }
    const whole = new Uint8Array(this.length);
    let at = 0;
    for (const chunk of this.chunks) {
      whole.set(chunk, at);
      at += chunk.length;
    }
    return whole;
  }
}
