#pragma once

#include <utility>

#include "protocol/decoding/member.h"
#include "protocol/decoding/payload_content.h"

namespace espalier::protocol {

/// Runs `decoder(root, value)` over a payload and turns a MemberFailure into an error value.
template <typename T, typename Decoder>
[[nodiscard]] Expected<T> decodePayload(const Payload& payload, Decoder&& decoder) {
  try {
    // a message that the bulk reader took is parsed again: it was read for another method
    const bool isBulk = payload.bulk() != nullptr;
    const JsonTree again(isBulk ? nlohmann::json::parse(payload.toText(), nullptr, false) : nlohmann::json());
    const auto* tree = isBulk ? &again.value : static_cast<const nlohmann::json*>(payload.value());
    T value{};
    std::vector<std::string>* const unknown = payload.unknownMembers();
    AskedMembers asked;
    decoder(Member(tree, payload.name(), unknown == nullptr ? nullptr : &asked), value);
    if (unknown != nullptr && tree != nullptr) {
      asked.listUnknown(*tree, payload.name(), *unknown);
    }
    return value;
  } catch (const MemberFailure& failure) {
    return tl::unexpected(failure.error);
  }
}

}  // namespace espalier::protocol
