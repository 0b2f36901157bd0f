#include "engine/language/program.h"

namespace espalier::language {

core::ModuleTypeId Program::findType(std::string_view name, std::uint16_t arityWanted) const {
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i].arity == arityWanted && symbols[types[i].symbol].name == name) {
      return static_cast<core::ModuleTypeId>(i);
    }
  }
  return core::kNoModuleType;
}

namespace {

enum ModeBit : std::uint16_t { kRead = 1, kWrite = 2, kTruncate = 4, kAppend = 8, kMustExist = 16 };

}  // namespace

std::optional<FileMode> FileMode::parse(std::string_view text) {
  FileMode mode;
  bool isUpdate = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (i == 0) {
      mode.canRead = mode.mustExist = c == 'r';
      mode.canWrite = c == 'w' || c == 'a';
      mode.truncates = c == 'w';
      mode.appends = c == 'a';
    } else if (c == '+') {
      isUpdate = true;
    } else if (c != 'b' && c != 't') {
      return std::nullopt;
    }
  }
  if (!mode.canRead && !mode.canWrite) {
    return std::nullopt;
  }
  mode.canRead = mode.canRead || isUpdate;
  mode.canWrite = mode.canWrite || isUpdate;
  return mode;
}

std::uint16_t FileMode::bits() const {
  const int bits = (canRead ? kRead : 0) | (canWrite ? kWrite : 0) | (truncates ? kTruncate : 0) |
                   (appends ? kAppend : 0) | (mustExist ? kMustExist : 0);
  return static_cast<std::uint16_t>(bits);
}

FileMode FileMode::fromBits(std::uint16_t bits) {
  return {(bits & kRead) != 0, (bits & kWrite) != 0, (bits & kTruncate) != 0, (bits & kAppend) != 0,
          (bits & kMustExist) != 0};
}

std::string FileMode::text() const {
  return std::string(appends ? "a" : truncates ? "w" : "r") + (canRead && canWrite ? "+" : "");
}

}  // namespace espalier::language
