#include "server/running/limit_errors.h"

#include "protocol/json_writer.h"

namespace espalier::server {

protocol::Error callSecondsError(std::uint64_t bound, const std::string& outcome, std::optional<std::uint64_t> step) {
  protocol::JsonWriter data;
  data.beginObject().key("limit").text("callSeconds").key("value").integer(bound + 1).key("bound").integer(bound);
  if (step) {
    data.key("step").integer(*step);
  }
  return {protocol::ErrorCode::Limit,
          "the limit 'callSeconds' is " + std::to_string(bound) + ", and this has computed longer. " + outcome +
              " Use a smaller model, or start the server with a higher --limit callSeconds=N.",
          data.endObject().take()};
}

}  // namespace espalier::server
