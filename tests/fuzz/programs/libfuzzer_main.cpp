#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tests/fuzz/targets.h"

// the function that libFuzzer calls; ESPALIER_FUZZ_TARGET is the target of this program
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  espalier::fuzz::ESPALIER_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
