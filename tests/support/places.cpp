#include "tests/support/places.h"

namespace espalier {

std::string sourceFolder() {
  return ESPALIER_SOURCE_DIR;
}

std::string buildFolder() {
  return ESPALIER_BINARY_DIR;
}

}  // namespace espalier
