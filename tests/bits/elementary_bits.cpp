// Compares the bits of elementary functions with the recorded ones. It needs no library, so that it also runs on
// processors for which nothing else is built: ./dev test --all bits.

#include <cinttypes>
#include <cstdio>
#include <cstdlib>

#include "tests/bits/elementary_cases.h"

int main() {
  using namespace espalier::test;
  int differing = 0;
  for (const ElementaryCase& entry : elementaryCases()) {
    const std::uint64_t bits = elementaryBits(entry);
    differing += bits == entry.bits ? 0 : 1;
    std::printf("%s %016" PRIx64 "%s\n", entry.name.c_str(), bits,
                bits == entry.bits ? "" : " is not the recorded one");
  }
  return differing == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
