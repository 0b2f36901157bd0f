#include "tests/fuzz/pieces.h"

#include "engine/core/hash.h"
#include "engine/simulation/byte_reader.h"
#include "engine/simulation/byte_writer.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/trace_format.h"

namespace espalier::fuzz {
namespace {

using simulation::ByteReader;
using simulation::ByteWriter;

constexpr std::size_t kHeadBytes = 12;  // magic and version
constexpr std::size_t kChecksumBytes = 8;

std::uint64_t checksumOf(std::string_view bytes) {
  core::Hasher hasher;
  hasher.bytes(bytes);
  return hasher.value();
}

/// An event with the right checks inside, where it can be read.
std::string repaired(const std::string& event) {
  simulation::TraceEvent read;
  if (!simulation::decodeEvent(event, read)) {
    return event;
  }
  if (read.kind == simulation::TraceEventKind::Step) {
    return simulation::encodeStep(read.queries, read.replies);
  }
  if (read.kind == simulation::TraceEventKind::Start) {
    if (const auto snapshot = cutIntoPieces(read.snapshot); snapshot && !snapshot->isTrace) {
      return simulation::encodeStart(joinPieces(*snapshot), read.hasEnvironment ? &read.description : nullptr,
                                     read.context);
    }
  }
  return event;
}

}  // namespace

std::optional<Pieces> cutIntoPieces(std::string_view bytes) {
  const bool isTrace = bytes.starts_with(simulation::kTraceMagic);
  if (bytes.size() < kHeadBytes || (!isTrace && !bytes.starts_with(simulation::kSnapshotMagic))) {
    return std::nullopt;
  }
  Pieces result;
  result.isTrace = isTrace;
  result.head = bytes.substr(0, kHeadBytes);
  ByteReader reader(bytes.substr(kHeadBytes));
  while (reader.remaining() > kChecksumBytes) {
    const std::uint32_t tag = isTrace ? 0 : reader.number32();
    const std::string_view piece = reader.raw(reader.number64());
    if (isTrace) {
      static_cast<void>(reader.number64());
    }
    if (reader.hasFailed()) {
      break;
    }
    result.pieces.push_back({tag, std::string(piece)});
  }
  return result.pieces.empty() ? std::nullopt : std::optional(std::move(result));
}

std::string joinPieces(const Pieces& pieces) {
  ByteWriter writer;
  writer.raw(pieces.head);
  for (const Pieces::Piece& piece : pieces.pieces) {
    if (pieces.isTrace) {
      const std::string event = repaired(piece.bytes);
      writer.text(event);
      writer.number64(checksumOf(event));
    } else {
      writer.number32(piece.tag);
      writer.text(piece.bytes);
    }
  }
  if (!pieces.isTrace) {
    writer.number64(checksumOf(writer.bytes()));
  }
  return writer.bytes();
}

}  // namespace espalier::fuzz
