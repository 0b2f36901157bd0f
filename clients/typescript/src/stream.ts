import type { Connection } from "./connection.js";
import { Geometry } from "./geometry.js";
import type { GeometryChange } from "./geometry.js";
import type { Methods, Statistics } from "./protocol.js";
import { turtleTable } from "./turtle.js";
import type { TurtleTable } from "./turtle.js";
import type { Columns } from "./wire.js";

type Data = Methods["stream.data"]["params"];

export interface StreamOptions {
  every?: number;
  maxHz?: number;
  /** Frames that may be unused: 1 gives the latest state to a slow reader. Default 2; undefined: only the connection's speed counts. */
  credits?: number;
  select?: { symbols?: string[]; plants?: number[] };
  precision?: "single";
}

/** The members of every frame. */
export interface Frame {
  simulation: string;
  step: number;
  sequence: number;
  key: boolean;
  missed: number;
  finished: boolean;
}

/** The further members of a frame of each kind of stream. */
export interface Contents {
  statistics: { statistics: Statistics };
  string: { string: string };
  turtle: { turtle: TurtleTable };
  columns: { geometry: Geometry; change: GeometryChange };
  glb: { glb: Uint8Array<ArrayBuffer> };
  queries: { queries: Data["queries"]; replies: Data["replies"] };
}

export type Kind = keyof Contents;
export type FrameOf<K extends Kind> = Frame & Contents[K];

/** Without credits the server waits for no frame to be used, and nothing needs to tell it so. */
const hasCredits = (options: StreamOptions): boolean => !("credits" in options) || options.credits !== undefined;

function openParams(kind: Kind, simulation: string, options: StreamOptions): Methods["stream.open"]["params"] {
  const base = { simulation, credits: 2, ...options };
  switch (kind) {
    case "columns":
      return { ...base, what: "geometry", format: "columns", bin: true, delta: true };
    case "glb":
      return { ...base, what: "geometry", bin: true };
    case "turtle":
      return { ...base, what: "turtle", bin: true, delta: true };
    case "string":
      return { ...base, what: "string", delta: true };
    default:
      return { ...base, what: kind };
  }
}

/**
 * Frames of a simulation, one after each step and change. Iterate over it. A frame counts as used, and the next may come,
 * when the loop asks for the next one; so a slow loop skips frames and never slows the simulation. Values of a frame
 * that are columns are valid until then. The loop ends when the stream is closed; when the server ends it, `reason` says why.
 */
export class Stream<K extends Kind> implements AsyncIterable<FrameOf<K>> {
  /** Why the server ended the stream. */
  reason: string | null = null;

  private identifier: string | null = null;
  private connection: Connection | null = null;
  private readonly queue: Array<{ params: Data; blocks: Columns }> = [];
  private wake: (() => void) | null = null;
  private isEnded = false;
  private unused: number | null = null; // the frame that the loop has now

  private text = "";
  private table: TurtleTable | null = null;
  private readonly geometry = new Geometry();

  constructor(
    readonly kind: K,
    readonly simulation: string,
    private readonly options: StreamOptions,
    private readonly onClosed: (stream: Stream<K>) => void,
  ) {}

  /** Opens the stream, again on a new connection after the first is lost. The next frame is complete in itself. */
  async open(connection: Connection): Promise<void> {
    const { stream } = await connection.call("stream.open", openParams(this.kind, this.simulation, this.options));
    this.queue.length = 0;
    this.unused = null;
    this.connection = connection;
    this.identifier = stream;
  }

  get id(): string | null {
    return this.identifier;
  }

  async close(): Promise<void> {
    if (!this.isEnded) {
      const { identifier, connection } = this;
      this.end(null);
      if (identifier && connection?.isOpen) {
        await connection.call("stream.close", { stream: identifier }).catch(() => {});
      }
    }
  }

  /** For the client: the stream has ended. */
  end(reason: string | null): void {
    if (!this.isEnded) {
      this.isEnded = true;
      this.reason = reason;
      this.onClosed(this);
      this.wake?.();
    }
  }

  /** For the client: a frame has come. */
  push(params: Data, blocks: Columns): void {
    this.queue.push({ params, blocks });
    this.wake?.();
  }

  async *[Symbol.asyncIterator](): AsyncGenerator<FrameOf<K>, void, void> {
    try {
      for (;;) {
        if (this.unused !== null && this.identifier && hasCredits(this.options)) {
          this.connection?.notify("stream.ack", { stream: this.identifier, sequence: this.unused });
          this.unused = null;
        }
        while (this.queue.length === 0 && !this.isEnded) {
          await new Promise<void>((wake) => (this.wake = wake));
        }
        const next = this.queue.shift();
        if (this.isEnded || !next) {
          return;
        }
        this.unused = next.params.sequence;
        yield this.frameOf(next.params, next.blocks);
      }
    } finally {
      await this.close();
    }
  }

  private frameOf(params: Data, blocks: Columns): FrameOf<K> {
    const { simulation, step, sequence, key, missed, finished } = params;
    return { simulation, step, sequence, key, missed, finished, ...this.content(params, blocks) } as unknown as FrameOf<K>;
  }

  private content(params: Data, blocks: Columns): Contents[Kind] {
    switch (this.kind as Kind) {
      case "columns":
        return { geometry: this.geometry, change: this.geometry.apply(params.geometry!, blocks) };
      case "glb": {
        const words = blocks["glb"];
        return { glb: new Uint8Array(words.buffer as ArrayBuffer, words.byteOffset, words.byteLength) };
      }
      case "turtle":
        this.table = turtleTable(params, blocks, params.key ? null : this.table);
        return { turtle: this.table };
      case "string": {
        const before = this.text;
        const pieces = params.pieces as Array<string | [number, number]> | undefined;
        this.text = pieces
          ? pieces.map((piece) => (typeof piece === "string" ? piece : before.slice(piece[0], piece[0] + piece[1]))).join("")
          : params.string!;
        return { string: this.text };
      }
      case "queries":
        return { queries: params.queries, replies: params.replies };
      default:
        return { statistics: params.statistics! };
    }
  }
}
