/** An error that the server answered. The numbers are in protocol/README.md. */
export class ServerError extends Error {
  override name = "ServerError";
  constructor(
    readonly code: number,
    message: string,
    readonly data: ErrorData = {},
  ) {
    super(message);
  }
}

/** Members depend on the code. */
export interface ErrorData {
  step?: number;
  plant?: number;
  module?: number;
  path?: string;
  limit?: string;
  role?: string;
  environment?: string;
  retryable?: boolean;
  file?: string;
  line?: number;
  column?: number;
  diagnostics?: Array<{ severity: string; message: string; text: string; file?: string; hint?: string }>;
  [name: string]: unknown;
}

/** The connection has ended before an answer came. The server may or may not have carried the request out. */
export class ConnectionLost extends Error {
  override name = "ConnectionLost";
}

/** Codes of errors that programs ask for. */
export const Code = {
  methodNotFound: -32601,
  invalidParams: -32602,
  internal: -32603,
  version: 1001,
  unauthorised: 1003,
  limit: 1004,
  timeout: 1005,
  environment: 1006,
  model: 1009,
  cancelled: 1010,
  notFound: 1011,
  modelChanged: 1017,
} as const;
