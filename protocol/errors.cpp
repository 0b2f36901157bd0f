#include "protocol/errors.h"

#include <algorithm>
#include <array>

#include "protocol/json_writer.h"

namespace espalier::protocol {
namespace {

constexpr std::array kErrors{
#define ESPALIER_ERROR(name, code, text, meaning, data, remedy) ErrorInfo{ErrorCode::name, text, meaning, data, remedy},
#include "protocol/errors.def"
};

}  // namespace

std::span<const ErrorInfo> allErrors() {
  return kErrors;
}

std::string_view nameOf(ErrorCode code) {
  const auto found = std::ranges::find(kErrors, code, &ErrorInfo::code);
  return found == kErrors.end() ? "unknown" : found->name;
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
          "the limit '" + std::string(limit) + "' is " + std::to_string(bound) + ", and this is " +
              std::to_string(value) + ". " + std::string(remedy),
          data.take()};
}

}  // namespace espalier::protocol
