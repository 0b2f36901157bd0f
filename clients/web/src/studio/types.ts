// What the server tells about itself.

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

/** What a schema says about a setting. */
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
