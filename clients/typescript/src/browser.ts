import { Client } from "./client.js";
import type { ClientOptions } from "./client.js";
import { dialWebSocket } from "./transport.js";

export { Client } from "./client.js";
export type { ClientOptions } from "./client.js";
export { Simulation } from "./simulation.js";
export { Stream } from "./stream.js";
export type { Contents, Frame, FrameOf, Kind, StreamOptions } from "./stream.js";
export { Geometry, ORGAN_KINDS } from "./geometry.js";
export type { GeometryChange } from "./geometry.js";
export { NEW_ROWS, Rows } from "./rows.js";
export type { Run, RowRange } from "./rows.js";
export type { TurtleTable } from "./turtle.js";
export { Code, ConnectionLost, ServerError } from "./errors.js";
export type { CallOptions, Method, Params, Result } from "./connection.js";
export type { Description, Environment, Opening, Query, Reply, Step } from "./environment.js";
export type * from "./protocol.js";

/** Connects to a server's HTTP side: `ws://HOST:PORT` or `wss://HOST:PORT`. */
export function connect(address: string, options?: ClientOptions): Promise<Client> {
  return Client.open(() => dialWebSocket(address), options);
}
