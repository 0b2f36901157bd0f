import { Code, ConnectionLost, ServerError } from "./errors.js";
import type { Methods } from "./protocol.js";
import type { Transport } from "./transport.js";
import type { Columns, Message, OutgoingBlock } from "./wire.js";

export type Method = keyof Methods;
export type Params<M extends Method> = Methods[M]["params"];
export type Result<M extends Method> = Methods[M]["result"];

/** The answer to a request of the peer. */
export interface Answer {
  result: unknown;
  blocks?: OutgoingBlock[];
}

export interface CallOptions {
  /** Gives the request up ($/cancel); the call then fails with error 1010. */
  signal?: AbortSignal;
  /** Called with the peer's `$/progress` about this request. */
  onProgress?: (progress: Params<"$/progress">) => void;
}

interface Waiting {
  done: (result: any) => void;
  failed: (error: Error) => void;
  onProgress?: CallOptions["onProgress"];
}

/** JSON-RPC over one transport, in both directions. */
export class Connection {
  /** Answers requests of the peer, other than ping. */
  onRequest: (method: string, params: any, blocks: Columns) => Promise<Answer> = async (method) => {
    throw new ServerError(Code.methodNotFound, `This client does not know the method '${method}'.`);
  };
  onNotification: (method: string, params: any, blocks: Columns) => void = () => {};
  onClosed: () => void = () => {};

  private readonly waiting = new Map<number, Waiting>();
  private lastId = 0;
  private isClosed = false;
  private refusal = ".";  // why the server ends the connection

  constructor(private readonly transport: Transport) {
    transport.onMessage = (message) => this.take(message);
    transport.onClose = () => this.closed();
  }

  get isOpen(): boolean {
    return !this.isClosed;
  }

  /** Sends a request and waits for its result. Fails with ServerError or ConnectionLost. */
  call<M extends Method>(method: M, params: Params<M>, options: CallOptions = {}): Promise<Result<M>> {
    if (this.isClosed) {
      return Promise.reject(new ConnectionLost("The connection to the server is closed" + this.refusal));
    }
    const id = ++this.lastId;
    return new Promise((done, failed) => {
      const cancel = () => this.notify("$/cancel", { id });
      const end = () => options.signal?.removeEventListener("abort", cancel);
      this.waiting.set(id, {
        done: (result) => (end(), done(result)),
        failed: (error) => (end(), failed(error)),
        onProgress: options.onProgress,
      });
      this.transport.send({ jsonrpc: "2.0", id, method, params });
      if (options.signal?.aborted) {
        cancel();
      }
      options.signal?.addEventListener("abort", cancel);
    });
  }

  notify<M extends Method>(method: M, params: Params<M>): void {
    if (!this.isClosed) {
      this.transport.send({ jsonrpc: "2.0", method, params });
    }
  }

  close(): void {
    this.transport.close();
    this.closed();
  }

  private closed(): void {
    if (this.isClosed) {
      return;
    }
    this.isClosed = true;
    for (const { failed } of this.waiting.values()) {
      failed(new ConnectionLost("The connection to the server is lost" + this.refusal));
    }
    this.waiting.clear();
    this.onClosed();
  }

  private take(message: Message): void {
    if (message.method !== undefined && message.id !== undefined) {
      void this.answer(message);
    } else if (message.method === "$/progress") {
      this.waiting.get(message.params.id)?.onProgress?.(message.params);
    } else if (message.method !== undefined) {
      this.onNotification(message.method, message.params ?? {}, message.blocks ?? {});
    } else if (message.id === null && message.error) {
      this.refusal = `: ${message.error.message}`;
    } else {
      const waiting = this.waiting.get(message.id as number);
      this.waiting.delete(message.id as number);
      if (message.error) {
        waiting?.failed(new ServerError(message.error.code, message.error.message, message.error.data));
      } else {
        waiting?.done(message.result);
      }
    }
  }

  private async answer(message: Message): Promise<void> {
    const head = { jsonrpc: "2.0" as const, id: message.id };
    try {
      const { result, blocks } =
        message.method === "ping" ? { result: {}, blocks: [] } : await this.onRequest(message.method!, message.params ?? {}, message.blocks ?? {});
      if (!this.isClosed) {
        this.transport.send({ ...head, result }, blocks);
      }
    } catch (error) {
      const known = error instanceof ServerError ? error : new ServerError(Code.internal, String((error as Error)?.message ?? error));
      if (!this.isClosed) {
        this.transport.send({ ...head, error: { code: known.code, message: known.message, data: known.data } });
      }
    }
  }
}
