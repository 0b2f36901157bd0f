import { Connection } from "./connection.js";
import type { CallOptions, Method, Params, Result } from "./connection.js";
import { environmentHandler } from "./environment.js";
import type { Environment } from "./environment.js";
import { Code, ConnectionLost, ServerError } from "./errors.js";
import type { Information, Model } from "./protocol.js";
import { Simulation } from "./simulation.js";
import { Stream } from "./stream.js";
import type { Kind, StreamOptions } from "./stream.js";
import type { Dial } from "./transport.js";
import type { Columns } from "./wire.js";

export interface ClientOptions {
  token?: string;
  /** The name that the server's log shows. */
  name?: string;
  roles?: Array<"controller" | "environment" | "viewer">;
  /** Connect again when the connection is lost; streams and offers go on. Default true. */
  reconnect?: boolean;
  /** Told when the connection is lost (false), and when it is there again (true). */
  onConnection?: (isConnected: boolean) => void;
  /** Told when the server is there again but refuses this client, as for a token that has expired. The client does not try again. */
  onRefused?: (error: Error) => void;
}

const CAPABILITIES = ["bin", "checkpoint", "cancel", "streams", "credits", "delta", "offer", "geometry", "iterate", "heartbeat"];
const FIRST_WAIT_MILLISECONDS = 200;
const LONGEST_WAIT_MILLISECONDS = 5000;

/** A connection to a server. Make one with `connect()`. */
export class Client {
  /** The server's answer to hello: its version, limits and the roles of this client. */
  hello!: Result<"hello">;

  private connection!: Connection;
  private readonly streams = new Set<Stream<Kind>>();
  private readonly early = new Map<string, Array<() => void>>(); // messages of streams that are being opened
  private opening = 0; // streams that are being opened
  private readonly offers = new Map<string, Environment>();
  private serve: ReturnType<typeof environmentHandler> | null = null;
  private isClosed = false;
  private reconnecting: Promise<void> | null = null;

  private constructor(
    private readonly dial: Dial,
    private readonly options: ClientOptions,
  ) {}

  static async open(dial: Dial, options: ClientOptions = {}): Promise<Client> {
    const client = new Client(dial, options);
    await client.connect();
    return client;
  }

  get isConnected(): boolean {
    return this.connection.isOpen;
  }

  /** Sends any request of the protocol. */
  call<M extends Method>(method: M, params: Params<M>, options?: CallOptions): Promise<Result<M>> {
    return this.connection.call(method, params, options);
  }

  /** Compiles a model: its diagnostics, symbols and length. */
  check(model: Model, parameters?: Record<string, number | string>): Promise<Result<"model.check">> {
    return this.call("model.check", { model, ...(parameters ? { parameters } : {}) });
  }

  gallery(): Promise<Result<"model.list">> {
    return this.call("model.list", {});
  }

  /** Makes a simulation. */
  async create(params: Params<"simulation.create">, options?: CallOptions): Promise<Simulation> {
    const made = await this.call("simulation.create", params, options);
    return new Simulation(this, made.simulation, made);
  }

  /** A simulation that is there already. */
  simulation(id: string): Simulation {
    return new Simulation(this, id);
  }

  async simulations(): Promise<Information[]> {
    return (await this.call("simulation.list", {})).simulations;
  }

  async stream<K extends Kind>(kind: K, simulation: string, options: StreamOptions = {}): Promise<Stream<K>> {
    const stream = new Stream(kind, simulation, options, (ended) => this.streams.delete(ended as unknown as Stream<Kind>));
    await this.openStream(stream as unknown as Stream<Kind>);
    return stream;
  }

  /** Offers an environment under a name: simulations use it as {"type":"offered","name":NAME}. One for each client. */
  async offer(name: string, environment: Environment): Promise<void> {
    if (this.offers.size > 0 && !this.offers.has(name)) {
      throw new Error("A client offers one environment. Connect a second client for another one.");
    }
    this.serve = environmentHandler(environment);
    await this.call("environment.offer", { name });
    this.offers.set(name, environment);
  }

  close(): void {
    this.isClosed = true;
    this.connection.close();
    for (const stream of [...this.streams]) {
      stream.end(null);
    }
  }

  private async openStream(stream: Stream<Kind>): Promise<void> {
    ++this.opening;
    try {
      await stream.open(this.connection);
      this.streams.add(stream);
      this.early.get(stream.id!)?.forEach((deliver) => deliver());
    } finally {
      // the messages of the others that are being opened are still to be delivered
      if (--this.opening === 0) {
        this.early.clear();
      }
    }
  }

  private async connect(): Promise<void> {
    const connection = new Connection(await this.dial());
    connection.onNotification = (method, params, blocks) => this.notified(method, params, blocks);
    connection.onRequest = async (method, params, blocks) => {
      if (!this.serve) {
        throw new ServerError(Code.methodNotFound, `This client offers no environment, so it does not answer ${method}.`);
      }
      return this.serve(method, params, blocks);
    };
    const { token, name = "espalier-typescript", roles } = this.options;
    try {
      this.hello = await connection.call("hello", {
        protocol: [1],
        name,
        version: "1",
        capabilities: CAPABILITIES,
        limits: { lineBytes: 256_000_000, blockBytes: 1_000_000_000 },
        ...(roles ? { roles } : {}),
        ...(token ? { token } : {}),
      });
    } catch (error) {
      connection.close();
      throw error;
    }
    this.connection = connection;
    connection.onClosed = () => this.lost();
  }

  private lost(): void {
    if (this.isClosed) {
      return;
    }
    this.options.onConnection?.(false);
    if (this.options.reconnect === false) {
      for (const stream of [...this.streams]) {
        stream.end("the connection to the server is lost");
      }
      return;
    }
    this.reconnecting ??= this.again().finally(() => (this.reconnecting = null));
  }

  /** Tries until the server is there again, then opens what was open. */
  private async again(): Promise<void> {
    for (let wait = FIRST_WAIT_MILLISECONDS; !this.isClosed; wait = Math.min(2 * wait, LONGEST_WAIT_MILLISECONDS)) {
      await new Promise((done) => setTimeout(done, wait));
      try {
        await this.connect();
        break;
      } catch (error) {
        if (!(error instanceof ConnectionLost)) {
          // a server that refuses this client refuses it again
          this.options.onRefused?.(error as Error);
          [...this.streams].forEach((stream) => stream.end((error as Error).message));
          return;
        }
      }
    }
    if (this.isClosed) {
      this.connection.close();
      return;
    }
    for (const name of this.offers.keys()) {
      await this.call("environment.offer", { name }).catch(() => {});
    }
    for (const stream of [...this.streams]) {
      this.streams.delete(stream);
      await this.openStream(stream).catch((error: Error) => {
        // lost once more: the next turn opens it
        if (error instanceof ConnectionLost) {
          this.streams.add(stream);
        } else {
          stream.end(error.message);
        }
      });
    }
    this.options.onConnection?.(true);
  }

  private notified(method: string, params: any, blocks: Columns): void {
    const deliver = () => {
      const stream = [...this.streams].find(({ id }) => id === params.stream);
      if (method === "stream.data") {
        stream?.push(params, blocks);
      } else if (method === "stream.end") {
        stream?.end(params.reason);
      }
      return stream !== undefined;
    };
    if (!deliver() && params.stream) {
      // the first frame may be here before the answer of stream.open is read
      const early = this.early.get(params.stream) ?? [];
      this.early.set(params.stream, [...early, deliver]);
    }
  }
}
