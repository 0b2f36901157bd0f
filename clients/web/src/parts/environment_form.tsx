// The environment of a model as forms, made from the JSON Schemas of its processes.
import { useState } from "preact/hooks";
import { publishedFileOf } from "../studio/document.js";
import type { Studio } from "../studio/studio.js";
import type { EnvironmentEntry, Property } from "../studio/types.js";
import { IconButton } from "./icons.js";
import { NumberField } from "./number_field.js";

type Process = Record<string, unknown> & { type: string };

const isNumeric = (type: string | undefined): boolean => type === "number" || type === "integer";
const same = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);

/** A text as a value of a list or of another structure; throws with a sentence for the reader. */
export function parseSetting(text: string, property: Property): unknown {
  if (property.type === "array" && isNumeric(property.items?.type)) {
    const numbers = text.trim() === "" ? [] : text.trim().split(/[\s,;]+/).map(Number);
    const [least, most] = [property.minItems ?? 0, property.maxItems ?? Infinity];
    if (numbers.some(Number.isNaN)) {
      throw new Error("Write numbers with commas between them.");
    }
    if (numbers.length < least || numbers.length > most) {
      throw new Error(least === most ? `Write ${least} numbers.` : `Write at least ${least}${most < Infinity ? `, at most ${most}` : ""} numbers.`);
    }
    return numbers;
  }
  try {
    return JSON.parse(text);
  } catch {
    throw new Error("This is no JSON. Write a list as [[1, 2, 3], [4, 5, 6]].");
  }
}

export function settingText(value: unknown, property: Property): string {
  const isPlain = property.type === "array" && isNumeric(property.items?.type) && Array.isArray(value);
  if (isPlain) {
    return value.join(", ");
  }
  // a row of a list is a line
  return Array.isArray(value) && value.length > 0 ? `[${value.map((one) => JSON.stringify(one)).join(",\n ")}]` : JSON.stringify(value);
}

function Setting({ id, name, property, value, onChange }: { id: string; name: string; property: Property; value: unknown; onChange: (value: unknown) => void }) {
  const [problem, setProblem] = useState("");
  const [draft, setDraft] = useState<string | null>(null); // a text that is refused stays
  const shown = value ?? property.default;
  const unit = property.unit && property.unit !== "1" ? property.unit : "";
  const structured = (text: string) => {
    try {
      onChange(parseSetting(text, property));
      setDraft(null);
      setProblem("");
    } catch (error) {
      setProblem((error as Error).message);
    }
  };
  const numeric = (input: HTMLInputElement) => {
    const isRight = input.checkValidity() && Number.isFinite(input.valueAsNumber);
    setProblem(isRight ? "" : input.validationMessage || "Write a number.");
    return isRight && (onChange(input.valueAsNumber), true);
  };
  const isList = property.type === "array" && !isNumeric(property.items?.type);
  let field;
  if (property.enum) {
    field = <select id={id} value={String(shown)} onChange={(event) => onChange(event.currentTarget.value)}>{property.enum.map((one) => <option key={one}>{one}</option>)}</select>;
  } else if (property.type === "boolean") {
    field = <input id={id} type="checkbox" checked={Boolean(shown)} onChange={(event) => onChange(event.currentTarget.checked)} />;
  } else if (isNumeric(property.type)) {
    field = (
      <NumberField id={id} step={property.type === "integer" ? 1 : "any"} min={property.minimum ?? property.exclusiveMinimum} max={property.maximum} value={shown as number} onDone={numeric} />
    );
  } else if (property.type === "string") {
    field = <textarea id={id} rows={1} spellcheck={false} value={draft ?? String(shown ?? "")} onInput={(event) => setDraft(event.currentTarget.value)} onChange={(event) => { setDraft(null); onChange(event.currentTarget.value); }} />;
  } else {
    const text = settingText(shown, property);
    field = <textarea id={id} rows={Math.min(text.split("\n").length, 8)} spellcheck={false} value={draft ?? text} onInput={(event) => setDraft(event.currentTarget.value)} onChange={(event) => structured(event.currentTarget.value)} />;
  }
  return (
    <div class={`setting ${value === undefined ? "" : "given"} ${isList ? "wide" : ""}`}>
      <label for={id} title={property.description}>{name} {unit && <span class="quiet">{unit}</span>}</label>
      {field}
      {problem && <p class="error" role="alert">{problem}</p>}
      <small>{property.description}</small>
    </div>
  );
}

function ProcessForm({ process, place, known, onChange, onRemove }: { process: Process; place: number; known: EnvironmentEntry | undefined; onChange: (process: Process) => void; onRemove: () => void }) {
  const properties = Object.entries(known?.schema?.properties ?? {});
  const title = process.type === "gallery" ? `of the gallery model ${process.model}` : String(process.type);
  const row = ([name, property]: [string, Property]) => {
    const change = (value: unknown) => {
      const next = { ...process, [name]: value };
      if (same(value, property.default)) {
        delete (next as Record<string, unknown>)[name];
      }
      onChange(next);
    };
    return <Setting key={name} id={`environment-${place}-${name}`} name={name} property={property} value={process[name]} onChange={change} />;
  };
  const given = properties.filter(([name]) => name in process);
  const others = properties.filter(([name]) => !(name in process));
  return (
    <section class="process" aria-label={title}>
      <h4>{title} <IconButton icon="close" label={`Remove ${title}`} onClick={onRemove} /></h4>
      {known?.description && <p class="quiet">{known.description.summary}</p>}
      {given.map(row)}
      {others.length > 0 && <details open={given.length === 0}><summary>{others.length} more settings, as usual</summary>{others.map(row)}</details>}
    </section>
  );
}

export function EnvironmentForm({ studio }: { studio: Studio }) {
  const processes = (studio.document.environment ?? []) as Process[];
  const published = publishedFileOf(studio.document);
  const put = (next: Process[]) => void studio.act(() => studio.setProcesses(next.length > 0 ? next : null));
  return (
    <div class="environment">
      <h3>Environment</h3>
      {processes.length === 0 && published in studio.document.files && <p class="quiet">The file {published} says what surrounds the plant. Change it and the files that it names as text.</p>}
      {processes.length === 0 && !(published in studio.document.files) && <p class="quiet">Nothing answers the queries of this model. Choose what surrounds the plant.</p>}
      {processes.map((process, i) => (
        <ProcessForm key={`${studio.document.title} ${i} ${process.type}`} process={process} place={i} known={studio.environments.find(({ name }) => name === process.type)}
          onChange={(next) => put(processes.map((one, k) => (k === i ? next : one)))} onRemove={() => put(processes.filter((_, k) => k !== i))} />
      ))}
      <select id="add-environment" aria-label="Add an environment" value="" onChange={(event) => put([...processes, { type: event.currentTarget.value }])}>
        <option value="" disabled>Add …</option>
        {studio.environments.map(({ name, description }) => <option key={name} value={name} title={description?.summary}>{name}</option>)}
      </select>
    </div>
  );
}
