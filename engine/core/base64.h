#pragma once

#include <string>
#include <string_view>

namespace espalier::core {

constexpr std::string_view kBase64Digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// RFC 4648 base64 with padding: how bytes stand in files of text. (The protocol, which needs nothing of the engine, has
/// its own.)
[[nodiscard]] std::string toBase64(std::string_view bytes);

}  // namespace espalier::core
