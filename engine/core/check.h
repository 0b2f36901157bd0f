#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace espalier::core {

/// A bug of Espalier itself. The server closes the simulation in which it happened, and runs on.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void throwInternalError(const char* expression, const char* file, int line, const std::string& values);

}  // namespace espalier::core

/// Checks a condition that only a bug of Espalier can make false. On in all builds. Throws InternalError.
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
