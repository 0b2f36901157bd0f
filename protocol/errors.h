#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace espalier::protocol {

/// Numbers in the `code` of an error. Frozen: a number is never reused or changed.
enum class ErrorCode : std::int32_t {
  // JSON-RPC 2.0
  Parse = -32700,           // not JSON; the id of the answer is null
  InvalidRequest = -32600,  // JSON, but not a message of the protocol
  UnknownMethod = -32601,
  InvalidParams = -32602,  // a wrong type, a missing or unacceptable value: `data.path` names the member
  Internal = -32603,       // a bug of the answering program

  // Espalier
  Version = 1001,            // no common protocol version; the connection is closed
  Capability = 1002,         // needs a capability that was not agreed
  Unauthorised = 1003,       // token missing, wrong or expired, or not allowed for this caller
  Limit = 1004,              // `data`: limit, value, bound
  Timeout = 1005,            // `data`: milliseconds
  EnvironmentFailed = 1006,  // `data`: environment, step, retryable
  StaleStep = 1007,          // an environment was asked for a step it has left behind
  NonFinite = 1008,          // NaN or infinity in a model or a reply
  Model = 1009,              // a model does not compile or failed while running; `data`: diagnostics
  Cancelled = 1010,
  NotFound = 1011,      // no such simulation, stream, model, gallery entry or environment
  HelloMissing = 1012,  // anything before a successful hello
  Snapshot = 1013,      // bytes that are not a snapshot of this model
  Storage = 1014,       // the data folder could not be read or written
  ShuttingDown = 1015,  // the server stops; ask again after it is back
  OfferTaken = 1016,    // another connection offers an environment of this name
  ModelChanged = 1017,  // a saved model is not the one that the save knows; `data`: revision
};

/// The name of a code as in the table of protocol/README.md; "unknown" for other numbers.
[[nodiscard]] std::string_view nameOf(ErrorCode code);

/// An error as it crosses the wire.
struct Error {
  ErrorCode code = ErrorCode::Internal;
  std::string message;  // whole sentences: what happened and what to do next
  std::string data;     // text of a JSON object; empty: none
};

/// A value, or the error that takes its place.
template <typename T>
using Expected = tl::expected<T, Error>;

/// Error with `data` = {"path": path}; the message starts with the path.
[[nodiscard]] Error memberError(const std::string& path, const std::string& what);

/// Error with `data` = {"limit", "value", "bound"}. The message names all three and ends in `remedy`.
[[nodiscard]] Error limitError(std::string_view limit, std::uint64_t value, std::uint64_t bound,
                               std::string_view remedy);

}  // namespace espalier::protocol
