// Writes src/protocol.ts, the types of every method of the protocol, from protocol/espalier-1.schema.json.
import { readFileSync, writeFileSync, existsSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const schema = JSON.parse(readFileSync(join(here, "../../protocol/espalier-1.schema.json"), "utf8"));

// a name of TypeScript's own gives way
const nameOf = (key) => (key === "record" ? "TurtleRecord" : key[0].toUpperCase() + key.slice(1));
const BASIC = { number: "number", integer: "number", string: "string", boolean: "boolean", null: "null" };

/** The TypeScript type of a part of the schema. */
function typeOf(part, indent) {
  if (part === true || part === undefined) {
    return "unknown";
  }
  if (part.$ref) {
    return nameOf(part.$ref.replace("#/$defs/", ""));
  }
  if (part.enum || part.const !== undefined) {
    return (part.enum ?? [part.const]).map((value) => JSON.stringify(value)).join(" | ");
  }
  if (part.anyOf && !part.properties) {
    return part.anyOf.map((option) => typeOf(option, indent)).join(" | ");
  }
  if (Array.isArray(part.type)) {
    return part.type.map((type) => typeOf({ ...part, type }, indent)).join(" | ");
  }
  if (part.type === "array") {
    const item = typeOf(part.items, indent);
    if (part.minItems === part.maxItems && part.minItems <= 4) {
      return `[${Array(part.minItems).fill(item).join(", ")}]`;
    }
    return /[ |]/.test(item) ? `Array<${item}>` : `${item}[]`;
  }
  if (part.type === "object" || part.properties) {
    return objectOf(part, indent);
  }
  return BASIC[part.type] ?? "unknown";
}

function objectOf(part, indent) {
  const members = Object.entries(part.properties ?? {});
  if (members.length === 0) {
    return part.additionalProperties ? `Record<string, ${typeOf(part.additionalProperties, indent)}>` : "Record<string, unknown>";
  }
  const required = new Set(part.required ?? []);
  const inner = `${indent}  `;
  const lines = members.map(([name, member]) => `${inner}${name}${required.has(name) ? "" : "?"}: ${typeOf(member, inner)};\n`);
  return `{\n${lines.join("")}${indent}}`;
}

const { methods, ...shapes } = schema.$defs;
let text = "// Made by generate.js from protocol/espalier-1.schema.json.\n\n";
for (const [name, part] of Object.entries(shapes)) {
  text += `export type ${nameOf(name)} = ${typeOf(part, "")};\n\n`;
}
text += "/** Params and result of each method, by its name. */\nexport interface Methods {\n";
for (const [name, { params, result }] of Object.entries(methods)) {
  text += `  ${JSON.stringify(name)}: {\n    params: ${typeOf(params, "    ")};\n    result: ${typeOf(result, "    ")};\n  };\n`;
}
text += "}\n";

const target = join(here, "src/protocol.ts");
if (!existsSync(target) || readFileSync(target, "utf8") !== text) {
  writeFileSync(target, text);
}
