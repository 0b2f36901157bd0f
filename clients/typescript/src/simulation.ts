import type { Client } from "./client.js";
import type { CallOptions, Params, Result } from "./connection.js";
import type { Kind, Stream, StreamOptions } from "./stream.js";

type Get = Params<"simulation.get">;

/** A simulation of the server. It lives there until somebody deletes it. */
export class Simulation {
  constructor(
    readonly client: Client,
    readonly id: string,
    /** The answer of its creation; absent for one that another program made. */
    readonly created?: Result<"simulation.create">,
  ) {}

  /** Makes steps. */
  step(steps = 1, options?: CallOptions): Promise<Result<"simulation.step">> {
    return this.client.call("simulation.step", { simulation: this.id, steps }, options);
  }

  /** Makes steps until so many are completed, or the model is finished. */
  stepUntil(until: number, options?: CallOptions): Promise<Result<"simulation.step">> {
    return this.client.call("simulation.step", { simulation: this.id, until }, options);
  }

  /** Makes steps until the model is finished. */
  run(options?: CallOptions): Promise<Result<"simulation.run">> {
    return this.client.call("simulation.run", { simulation: this.id, ...(options?.onProgress ? { progress: true } : {}) }, options);
  }

  pause(): Promise<Result<"simulation.pause">> {
    return this.client.call("simulation.pause", { simulation: this.id });
  }

  reset(seed?: number): Promise<Result<"simulation.reset">> {
    return this.client.call("simulation.reset", { simulation: this.id, ...(seed === undefined ? {} : { seed }) });
  }

  /** Gives variables, or names of `#define`, new values from the next step on. */
  set(parameters: Record<string, number | string>): Promise<Result<"simulation.set">> {
    return this.client.call("simulation.set", { simulation: this.id, parameters });
  }

  edit(change: Omit<Params<"simulation.edit">, "simulation">): Promise<Result<"simulation.edit">> {
    return this.client.call("simulation.edit", { simulation: this.id, ...change });
  }

  /** The state as a snapshot in base64. */
  async save(): Promise<string> {
    return (await this.client.call("simulation.save", { simulation: this.id })).snapshot!;
  }

  restore(snapshot: string): Promise<Result<"simulation.restore">> {
    return this.client.call("simulation.restore", { simulation: this.id, snapshot });
  }

  /** Keeps the state on the server's disk under a name. */
  checkpoint(name: string): Promise<Result<"simulation.save">> {
    return this.client.call("simulation.save", { simulation: this.id, checkpoint: name });
  }

  restoreCheckpoint(checkpoint: string): Promise<Result<"simulation.restore">> {
    return this.client.call("simulation.restore", { simulation: this.id, checkpoint });
  }

  /** A second simulation in the same state. */
  async fork(name?: string): Promise<Simulation> {
    const made = await this.client.call("simulation.fork", { simulation: this.id, ...(name ? { name } : {}) });
    return new Simulation(this.client, made.simulation, made);
  }

  get(what: Get["what"], more: Omit<Get, "what" | "simulation"> = {}): Promise<Result<"simulation.get">> {
    return this.client.call("simulation.get", { simulation: this.id, what, ...more });
  }

  async string(plant = 0): Promise<string> {
    return (await this.get("string", { plant })).string!;
  }

  async stateHash(): Promise<string> {
    return (await this.get("state-hash")).stateHash!;
  }

  /** Watches: `for await (const frame of await simulation.stream("columns")) …`. */
  stream<K extends Kind>(kind: K, options: StreamOptions = {}): Promise<Stream<K>> {
    return this.client.stream(kind, this.id, options);
  }

  async delete(): Promise<void> {
    await this.client.call("simulation.delete", { simulation: this.id });
  }
}
