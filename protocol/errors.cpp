#include "protocol/errors.h"

#include "protocol/json_writer.h"

namespace espalier::protocol {

std::string_view nameOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::Parse:
      return "parse";
    case ErrorCode::InvalidRequest:
      return "invalid request";
    case ErrorCode::UnknownMethod:
      return "unknown method";
    case ErrorCode::InvalidParams:
      return "invalid params";
    case ErrorCode::Internal:
      return "internal";
    case ErrorCode::Version:
      return "version";
    case ErrorCode::Capability:
      return "capability";
    case ErrorCode::Unauthorised:
      return "unauthorised";
    case ErrorCode::Limit:
      return "limit";
    case ErrorCode::Timeout:
      return "timeout";
    case ErrorCode::EnvironmentFailed:
      return "environment failed";
    case ErrorCode::StaleStep:
      return "stale step";
    case ErrorCode::NonFinite:
      return "non-finite";
    case ErrorCode::Model:
      return "model";
    case ErrorCode::Cancelled:
      return "cancelled";
    case ErrorCode::NotFound:
      return "not found";
    case ErrorCode::HelloMissing:
      return "hello missing";
    case ErrorCode::Snapshot:
      return "snapshot";
    case ErrorCode::Storage:
      return "storage";
    case ErrorCode::ShuttingDown:
      return "shutting down";
    case ErrorCode::OfferTaken:
      return "offer taken";
    case ErrorCode::ModelChanged:
      return "model changed";
  }
  return "unknown";
}

Error memberError(const std::string& path, const std::string& what) {
  JsonWriter data;
  data.beginObject().key("path").text(path).endObject();
  return {ErrorCode::InvalidParams, path + ": " + what, data.take()};
}

Error limitError(std::string_view limit, std::uint64_t value, std::uint64_t bound, std::string_view remedy) {
  JsonWriter data;
  data.beginObject().key("limit").text(limit).key("value").integer(value).key("bound").integer(bound).endObject();
  return {ErrorCode::Limit,
          std::string(limit) + " is limited to " + std::to_string(bound) + ", this is " + std::to_string(value) + ". " +
              std::string(remedy),
          data.take()};
}

}  // namespace espalier::protocol
