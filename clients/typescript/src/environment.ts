// Environments: they answer the queries of the plants in each step. protocol/README.md, Environments.
import type { Answer } from "./connection.js";
import { Code, ServerError } from "./errors.js";
import { Geometry } from "./geometry.js";
import type { Methods } from "./protocol.js";
import type { Columns } from "./wire.js";

type Vector = [number, number, number];
type StepParams = Methods["environment.step"]["params"];

/** One communication module that asks. Members beyond `parameters` are there when the environment needs them. */
export interface Query {
  id: number;
  plant: number;
  module?: number;
  symbol: string;
  parameters: number[];
  position?: Vector;
  heading?: Vector;
  left?: Vector;
  up?: Vector;
  width?: number;
  scale?: number;
  transient?: boolean;
  following?: { symbol: string; parameters: number[] };
}

export interface Step {
  simulation: string;
  /** Completed steps. */
  step: number;
  /** How often this step has been asked before (iterated coupling). */
  iteration: number;
  /** In days. */
  time: number;
  queries: Query[];
  /** The shapes of the plants, for an environment whose `needs` have `geometry`. */
  geometry?: Geometry;
  /** Says a sentence to the user of the simulation, as "no query lies in the field". The same sentence is shown once. */
  note(sentence: string): void;
}

/** The answer to one query: new parameters; null, undefined or a shorter list keep what the module has. */
export type Reply = Array<number | null> | number | null | undefined;

export type Description = Partial<Methods["environment.describe"]["result"]>;
export type Opening = Methods["environment.open"]["params"];

/** Implement `step`; the rest as far as the environment needs it. A class of yours may have state for each simulation. */
export interface Environment {
  /** Which members of queries it needs, and what it gives. Without it everything is sent. */
  describe?(): Description;
  open?(opening: Opening): void | Promise<void>;
  /** The replies, in the order of the queries. */
  step(step: Step): Reply[] | Promise<Reply[]>;
  /** The state, for an environment that says `checkpoint` in its description. */
  save?(simulation: string): Uint8Array | Promise<Uint8Array>;
  restore?(simulation: string, state: Uint8Array): void | Promise<void>;
  close?(simulation: string): void | Promise<void>;
}

const NONE = 0xffffffff;

function rowsOf(blocks: Columns, name: string, offsets: string, count: number): (i: number) => number[] {
  const values = blocks[name];
  const offset = blocks[offsets];
  if (!values) {
    return () => [];
  }
  const width = count > 0 ? values.length / count : 0;
  return offset
    ? (i) => Array.from(values.subarray(offset[i], offset[i + 1]))
    : (i) => Array.from(values.subarray(i * width, (i + 1) * width));
}

/** The queries of a step, from its blocks or its text. */
function queriesOf(params: StepParams, blocks: Columns): Query[] {
  if (!blocks["plant"]) {
    return (params.queries ?? []) as Query[];
  }
  const count = blocks["plant"].length;
  const symbols = params.symbols ?? [];
  const parameters = rowsOf(blocks, "parameters", "parameterOffset", count);
  const followingParameters = rowsOf(blocks, "followingParameters", "followingOffset", count);
  const vectors = (["position", "heading", "left", "up"] as const).filter((name) => blocks[name]);
  const numbers = (["width", "scale"] as const).filter((name) => blocks[name]);
  return Array.from({ length: count }, (_, i) => {
    const query: Query = { id: i, plant: blocks["plant"][i], symbol: symbols[blocks["symbol"][i]], parameters: parameters(i) };
    if (blocks["module"]) {
      query.module = blocks["module"][i];
    }
    if (blocks["transient"]?.[i]) {
      query.transient = true;
    }
    for (const name of vectors) {
      query[name] = Array.from(blocks[name].subarray(3 * i, 3 * i + 3)) as Vector;
    }
    for (const name of numbers) {
      query[name] = blocks[name][i];
    }
    if (blocks["following"] && blocks["following"][i] !== NONE) {
      query.following = { symbol: symbols[blocks["following"][i]], parameters: followingParameters(i) };
    }
    return query;
  });
}

function repliesOf(queries: Query[], replies: Reply[], notes: string[], isBinary: boolean): Answer {
  if (!Array.isArray(replies) || replies.length !== queries.length) {
    const found = Array.isArray(replies) ? String(replies.length) : typeof replies;
    throw new ServerError(Code.internal, `The environment must return ${queries.length} replies, one for each query; it returned ${found}.`);
  }
  const lists = replies.map((reply) => (reply === null || reply === undefined ? [] : typeof reply === "number" ? [reply] : reply));
  const said = notes.length > 0 ? { notes } : {};
  if (!isBinary) {
    return { result: { ...said, replies: lists.flatMap((parameters, i) => (parameters.length ? [{ id: queries[i].id, parameters }] : [])) } };
  }
  const offsets = new Uint32Array(lists.length + 1);
  lists.forEach((list, i) => (offsets[i + 1] = offsets[i] + list.length));
  const values = lists.flat();
  return {
    result: said,
    blocks: [
      { name: "parameters", values: Float64Array.from(values, (value) => value ?? 0) },
      { name: "parameterOffset", values: offsets },
      { name: "set", values: Uint32Array.from(values, (value) => (value === null ? 0 : 1)) },
    ],
  };
}

const base64 = {
  encode: (bytes: Uint8Array) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join("")),
  decode: (text: string) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0)),
};

/** Answers the requests of a server to an environment. */
export function environmentHandler(environment: Environment): (method: string, params: any, blocks: Columns) => Promise<Answer> {
  const geometries = new Map<string, Geometry>();
  return async (method, params, blocks) => {
    switch (method) {
      case "environment.describe":
        if (environment.describe) {
          return { result: environment.describe() };
        }
        break;
      case "environment.open":
        geometries.delete(params.simulation);
        await environment.open?.(params);
        return { result: {} };
      case "environment.step": {
        const { simulation, step, iteration, time } = params as StepParams;
        const queries = queriesOf(params, blocks);
        let geometry: Geometry | undefined;
        if (params.geometry) {
          geometry = geometries.get(simulation) ?? new Geometry();
          geometry.apply(params.geometry, blocks);
          geometries.set(simulation, geometry);
        }
        const notes: string[] = [];
        const note = (sentence: string) => void notes.push(sentence);
        const replies = await environment.step({ simulation, step, iteration: iteration ?? 0, time: time ?? 0, queries, geometry, note });
        return repliesOf(queries, replies, notes, blocks["plant"] !== undefined);
      }
      case "environment.save":
        if (environment.save) {
          return { result: { state: base64.encode(await environment.save(params.simulation)) } };
        }
        break;
      case "environment.restore":
        if (environment.restore) {
          await environment.restore(params.simulation, base64.decode(params.state));
          return { result: {} };
        }
        break;
      case "environment.close":
        geometries.delete(params.simulation);
        await environment.close?.(params.simulation);
        return { result: {} };
    }
    throw new ServerError(Code.methodNotFound, `This environment does not answer ${method}.`);
  };
}
