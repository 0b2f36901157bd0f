#include "engine/core/check.h"

namespace espalier::core {

void throwInternalError(const char* expression, const char* file, int line, const std::string& values) {
  std::string message = "internal error: '";
  message += expression;
  message += "' does not hold at ";
  // the path from the repository's root is enough and says nothing about the machine
  std::string_view path = file;
  for (const std::string_view root : {"tests/", "engine/", "environment/", "protocol/", "server/", "clients/"}) {
    const std::size_t found = path.rfind(root);
    if (found != std::string_view::npos) {
      path = path.substr(found);
      break;
    }
  }
  message += path;
  message += ':';
  message += std::to_string(line);
  if (!values.empty()) {
    message += " (";
    message += values;
    message += ')';
  }
  throw InternalError(message);
}

}  // namespace espalier::core
