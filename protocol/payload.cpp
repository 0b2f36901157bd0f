#include "protocol/payload.h"

#include "protocol/decoding/payload_content.h"

namespace espalier::protocol {

std::string Payload::toText() const {
  if (bulk_ != nullptr) {
    return std::string(bulk_->json);
  }
  return value_ == nullptr ? "null" : static_cast<const nlohmann::json*>(value_)->dump();
}

}  // namespace espalier::protocol
