#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace espalier::core {

/// A bug of Espalier itself. It closes the simulation it happened in, never the server.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void throwInternalError(const char* expression, const char* file, int line, const std::string& values);

}  // namespace espalier::core

/// Checks what can only be false through our own bug; on in all builds. Throws InternalError.
#define ESPALIER_CHECK(expression)                                               \
  do {                                                                           \
    if (!(expression)) {                                                         \
      ::espalier::core::throwInternalError(#expression, __FILE__, __LINE__, {}); \
    }                                                                            \
  } while (false)

/// The same with values for the message: a std::string.
#define ESPALIER_CHECK_VALUES(expression, values)                                      \
  do {                                                                                 \
    if (!(expression)) {                                                               \
      ::espalier::core::throwInternalError(#expression, __FILE__, __LINE__, (values)); \
    }                                                                                  \
  } while (false)
