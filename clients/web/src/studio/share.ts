// A model in a link: its files, packed, behind the # of the address, which browsers send to no server.
import type { Document } from "./document.js";

export interface Shared {
  document: Document;
  seed: number;
  step: number;
}

async function through(bytes: Uint8Array, stream: CompressionStream | DecompressionStream): Promise<Uint8Array> {
  const blob = new Blob([bytes as Uint8Array<ArrayBuffer>]).stream().pipeThrough(stream as unknown as ReadableWritablePair<Uint8Array, Uint8Array<ArrayBuffer>>);
  return new Uint8Array(await new Response(blob).arrayBuffer());
}

async function packed(shared: Shared): Promise<string> {
  const bytes = await through(new TextEncoder().encode(JSON.stringify(shared)), new CompressionStream("deflate-raw"));
  let text = "";
  for (const byte of bytes) {
    text += String.fromCharCode(byte);
  }
  return btoa(text).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

/** A link to the page with the plant as it is now, which others may change without changing this one. */
export async function linkTo({ document, seed, step }: Shared): Promise<string> {
  return `${location.origin}${location.pathname}#model=${await packed({ document, seed, step })}`;
}

export async function unpacked(text: string): Promise<Shared> {
  const bytes = Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (c) => c.charCodeAt(0));
  const shared = JSON.parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw")))) as Shared;
  if (typeof shared.document?.main !== "string" || typeof shared.document.files !== "object") {
    throw new Error("The link holds no model.");
  }
  shared.document.saved = null; // on another server, perhaps
  return shared;
}

/** Gives the reader a file. */
export function download(name: string, content: Blob | string): void {
  const blob = typeof content === "string" ? new Blob([content]) : content;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
