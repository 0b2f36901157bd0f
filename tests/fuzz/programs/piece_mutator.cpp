#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>

#include "tests/fuzz/pieces.h"

// libFuzzer's own changes, to one piece of a snapshot or a trace at a time: lengths and checksums stay right

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t maximumSize);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t maximumSize,
                                               unsigned seed);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t maximumSize,
                                               unsigned seed) {
  using namespace espalier::fuzz;
  std::mt19937 random(seed);
  auto pieces = cutIntoPieces({reinterpret_cast<const char*>(data), size});
  // now and then the frame too
  if (!pieces || random() % 20 == 0) {
    return LLVMFuzzerMutate(data, size, maximumSize);
  }
  std::vector<Pieces::Piece>& list = pieces->pieces;
  const std::size_t chosen = random() % list.size();
  if (random() % 20 == 0) {
    // leave one out, or have it twice
    const auto place = list.begin() + static_cast<std::ptrdiff_t>(chosen);
    random() % 2 == 0 ? list.erase(place) : list.insert(place, Pieces::Piece(*place));
  } else {
    std::string& bytes = list[chosen].bytes;
    const std::size_t before = bytes.size();
    // mostly of the same length: offsets and counts inside stay where they are
    const std::size_t room = random() % 4 == 0 ? before + 64 : std::max<std::size_t>(before, 1);
    bytes.resize(room);
    bytes.resize(
        LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), std::max<std::size_t>(before, 1), room));
  }
  const std::string changed = joinPieces(*pieces);
  if (changed.size() > maximumSize) {
    return size;
  }
  std::memcpy(data, changed.data(), changed.size());
  return changed.size();
}
