// The server's information about itself.

export type Connection = "connecting" | "connected" | "lost" | "token" | "failed";

export interface GalleryEntry {
  name: string;
  picture: string | null;
}

/** A process of the environment that the server knows. */
export interface EnvironmentEntry {
  name: string;
  description?: { summary: string };
  schema?: { properties: Record<string, Property> };
}

/** The part of a schema about a setting. */
export interface Property {
  type?: string;
  enum?: string[];
  default?: unknown;
  description?: string;
  unit?: string;
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  minItems?: number;
  maxItems?: number;
  items?: { type?: string };
}
