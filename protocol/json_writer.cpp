#include "protocol/json_writer.h"

#include <array>
#include <charconv>
#include <cmath>

namespace espalier::protocol {
namespace {

/// Length of the well-formed UTF-8 sequence at the start of `text`; 0: malformed (overlong, surrogate, cut off).
std::size_t sequenceLength(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto isTail = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned lead = byte(0);
  if (lead < 0x80U) {
    return 1;
  }
  if (lead >= 0xC2U && lead <= 0xDFU) {
    return isTail(1) ? 2 : 0;
  }
  if (lead >= 0xE0U && lead <= 0xEFU) {
    const bool isBad = (lead == 0xE0U && byte(1) < 0xA0U) || (lead == 0xEDU && byte(1) > 0x9FU);
    return !isBad && isTail(1) && isTail(2) ? 3 : 0;
  }
  if (lead >= 0xF0U && lead <= 0xF4U) {
    const bool isBad = (lead == 0xF0U && byte(1) < 0x90U) || (lead == 0xF4U && byte(1) > 0x8FU);
    return !isBad && isTail(1) && isTail(2) && isTail(3) ? 4 : 0;
  }
  return 0;
}

void appendEscaped(std::string& out, char c) {
  constexpr std::string_view kHex = "0123456789abcdef";
  switch (c) {
    case '"':
      out += "\\\"";
      return;
    case '\\':
      out += "\\\\";
      return;
    case '\n':
      out += "\\n";
      return;
    case '\r':
      out += "\\r";
      return;
    case '\t':
      out += "\\t";
      return;
    default:
      out += "\\u00";
      out += kHex[static_cast<unsigned char>(c) >> 4U];
      out += kHex[static_cast<unsigned char>(c) & 0xFU];
  }
}

}  // namespace

void JsonWriter::separate() {
  if (needsComma_) {
    text_ += ',';
  }
  needsComma_ = true;
}

JsonWriter& JsonWriter::beginObject() {
  separate();
  text_ += '{';
  needsComma_ = false;
  return *this;
}

JsonWriter& JsonWriter::endObject() {
  text_ += '}';
  needsComma_ = true;
  return *this;
}

JsonWriter& JsonWriter::beginArray() {
  separate();
  text_ += '[';
  needsComma_ = false;
  return *this;
}

JsonWriter& JsonWriter::endArray() {
  text_ += ']';
  needsComma_ = true;
  return *this;
}

JsonWriter& JsonWriter::key(std::string_view name) {
  separate();
  text_ += '"';
  text_ += name;
  text_ += "\":";
  needsComma_ = false;
  return *this;
}

JsonWriter& JsonWriter::text(std::string_view value) {
  separate();
  text_ += '"';
  const auto isPlain = [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20U && byte < 0x80U && c != '"' && c != '\\';
  };
  for (std::size_t i = 0; i < value.size();) {
    std::size_t end = i;
    while (end < value.size() && isPlain(value[end])) {
      ++end;
    }
    text_.append(value.substr(i, end - i));
    i = end;
    if (i == value.size()) {
      break;
    }
    const auto c = static_cast<unsigned char>(value[i]);
    if (c < 0x20U || c == '"' || c == '\\') {
      appendEscaped(text_, value[i++]);
      continue;
    }
    const std::size_t length = sequenceLength(value.substr(i));
    if (length == 0) {
      text_ += "\xEF\xBF\xBD";
      ++i;
      continue;
    }
    text_.append(value.substr(i, length));
    i += length;
  }
  text_ += '"';
  return *this;
}

JsonWriter& JsonWriter::number(double value) {
  if (!std::isfinite(value) || (isSinglePrecision_ && !std::isfinite(static_cast<float>(value)))) {
    throw NonFiniteNumber();
  }
  separate();
  if (isSinglePrecision_) {
    value = static_cast<double>(static_cast<float>(value));
  }
  if (value == 0.0 && std::signbit(value)) {
    text_ += "-0.0";
    return *this;
  }
  std::array<char, 32> buffer{};
  char* const end = buffer.data() + buffer.size();
  const auto result = isSinglePrecision_ ? std::to_chars(buffer.data(), end, static_cast<float>(value))
                                         : std::to_chars(buffer.data(), end, value);
  text_.append(buffer.data(), result.ptr);
  return *this;
}

JsonWriter& JsonWriter::integer(std::uint64_t value) {
  separate();
  std::array<char, 24> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text_.append(buffer.data(), result.ptr);
  return *this;
}

JsonWriter& JsonWriter::integer(std::int64_t value) {
  separate();
  std::array<char, 24> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text_.append(buffer.data(), result.ptr);
  return *this;
}

JsonWriter& JsonWriter::boolean(bool value) {
  separate();
  text_ += value ? "true" : "false";
  return *this;
}

JsonWriter& JsonWriter::null() {
  separate();
  text_ += "null";
  return *this;
}

JsonWriter& JsonWriter::raw(std::string_view json) {
  separate();
  text_ += json;
  return *this;
}

JsonWriter& JsonWriter::numbers(std::span<const double> values) {
  beginArray();
  for (const double value : values) {
    number(value);
  }
  return endArray();
}

JsonWriter& JsonWriter::texts(const std::vector<std::string>& values) {
  beginArray();
  for (const std::string& value : values) {
    text(value);
  }
  return endArray();
}

}  // namespace espalier::protocol
