#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::fuzz {

/// A snapshot or a trace, cut at its lengths: a fuzzer changes one piece and the file around it stays readable.
struct Pieces {
  struct Piece {
    std::uint32_t tag = 0;  // of a snapshot's section; of a trace nothing
    std::string bytes;
  };
  bool isTrace = false;
  std::string head;  // magic and version
  std::vector<Piece> pieces;
};

/// Cuts a file as far as its lengths hold. Nothing: it is neither a snapshot nor a trace, or has no piece.
[[nodiscard]] std::optional<Pieces> cutIntoPieces(std::string_view bytes);

/// The file again, with lengths and every checksum made right: of a trace also those of the snapshot in it and of the
/// replies.
[[nodiscard]] std::string joinPieces(const Pieces& pieces);

}  // namespace espalier::fuzz
