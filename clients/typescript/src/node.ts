import { Client } from "./client.js";
import type { ClientOptions } from "./client.js";
import { Connection } from "./connection.js";
import { environmentHandler } from "./environment.js";
import type { Environment } from "./environment.js";
import { dialTcp, lineTransport } from "./tcp.js";
import { dialWebSocket } from "./transport.js";

export * from "./browser.js";

export interface NodeOptions extends ClientOptions {
  /** PEM text of a certificate that `tls://` trusts besides the machine's own. */
  certificateAuthority?: string;
}

/** Connects to a server: `HOST:PORT`, `tcp://…`, `tls://…`, `unix:PATH`; `ws://…` where Node.js has WebSockets. */
export function connect(address: string, options: NodeOptions = {}): Promise<Client> {
  const isWebSocket = /^(ws|http)s?:/.test(address);
  return Client.open(() => (isWebSocket ? dialWebSocket(address) : dialTcp(address, options.certificateAuthority)), options);
}

/** Answers on standard input and output, for `--environment 'stdio:node light.js'`. Ends when the input ends. */
export function serveStdio(environment: Environment, name = "environment"): Promise<void> {
  const transport = lineTransport(process.stdin, process.stdout, () => process.stdin.destroy());
  const connection = new Connection(transport);
  const answer = environmentHandler(environment);
  connection.onRequest = async (method, params, blocks) =>
    method === "hello"
      ? { result: { protocol: 1, session: name, server: name, capabilities: ["bin", "geometry", "iterate", "checkpoint"], limits: {} } }
      : answer(method, params, blocks);
  return new Promise((ended) => (connection.onClosed = ended));
}
