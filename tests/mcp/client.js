// The official SDK of the Model Context Protocol as a client of a command, or of an address with the token ESPALIER_MCP_TOKEN:
// node client.js COMMAND ARGUMENTS... | http://HOST:PORT/mcp
// Standard output gets one JSON object with what the tools answered; the test in Python compares it.
import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";
import { StreamableHTTPClientTransport } from "@modelcontextprotocol/sdk/client/streamableHttp.js";

const [command, ...args] = process.argv.slice(2);
const client = new Client({ name: "espalier-test", version: "1" });
const transport = command.startsWith("http:")
  ? new StreamableHTTPClientTransport(new URL(command), { requestInit: { headers: { Authorization: `Bearer ${process.env.ESPALIER_MCP_TOKEN}` } } })
  : new StdioClientTransport({ command, args, env: process.env, stderr: "inherit" });
await client.connect(transport);
const call = (name, given = {}) => client.callTool({ name, arguments: given });

const answers = { server: client.getServerVersion(), tools: (await client.listTools()).tools.map((tool) => tool.name) };
const source = "Lsystem: 1\nderivation length: 4\nAxiom: A\nA --> F[+A]A\nendlsystem\n";
answers.wrong = await call("check", { source: source.replace("+A]", "+A") });
answers.check = await call("check", { source });
const created = await call("create", { source, seed: 7 });
const simulation = JSON.parse(created.content[0].text).simulation;
answers.step = await call("step", { simulation, steps: 3 });
answers.string = await call("query", { simulation, what: "string" });
answers.explain = await call("explain", { simulation, module: 3 });
answers.render = await call("render", { simulation, width: 120, height: 90 });
answers.refused = await call("step", { simulation, steps: -1 });
answers.spawn = await call("create", { source, environment: [{ type: "stdio", command: "touch spawned" }] });
answers.unknown = await call("nothing").catch((error) => ({ code: error.code }));
await client.ping();
await transport.terminateSession?.();
await client.close();
process.stdout.write(JSON.stringify(answers));
