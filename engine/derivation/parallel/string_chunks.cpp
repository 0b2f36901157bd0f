#include "engine/derivation/parallel/string_chunks.h"

#include <algorithm>

namespace espalier::derivation {
namespace {

// chunks whose parameters are counted, and brackets linked, by one thread at a time
constexpr std::uint64_t kPartChunks = 16;

}  // namespace

StringChunks::StringChunks(const language::Program& program)
    : parameterSum_({program.arity.begin(), program.arity.end()}) {}

void StringChunks::cut(const ModuleString& string, std::uint64_t chunkModules, core::WorkerTeam& team,
                       StringIndex* links) {
  size_ = string.size();
  chunkModules_ = chunkModules;
  const std::uint64_t chunkCount = (size_ + chunkModules - 1) / chunkModules;
  const std::uint64_t partCount = (chunkCount + kPartChunks - 1) / kPartChunks;
  offsets_.assign(chunkCount + 1, 0);
  if (links != nullptr) {
    links->beginParts(size_);
    openEnds_.resize(std::max<std::uint64_t>(openEnds_.size(), partCount));
  }
  if (string.parameterCount() == 0 && links == nullptr) {
    return;
  }
  // each part on its own
  const core::ModuleTypeId* types = string.types().data();
  team.forEach(partCount, [&](std::size_t part) {
    const std::uint64_t firstChunk = part * kPartChunks;
    const std::uint64_t endChunk = std::min(firstChunk + kPartChunks, chunkCount);
    for (std::uint64_t chunk = firstChunk; chunk < endChunk; ++chunk) {
      const std::uint64_t first = chunk * chunkModules;
      offsets_[chunk + 1] = parameterSum_.of(types + first, std::min(chunkModules, size_ - first));
    }
    if (links != nullptr) {
      links->linkPart(types, firstChunk * chunkModules, std::min(endChunk * chunkModules, size_), openEnds_[part]);
    }
  });
  // then all together
  for (std::uint64_t chunk = 0; chunk < chunkCount; ++chunk) {
    offsets_[chunk + 1] += offsets_[chunk];
  }
  for (std::uint64_t part = 0; part < (links != nullptr ? partCount : 0); ++part) {
    links->joinPart(openEnds_[part], offsets_[part * kPartChunks]);
  }
}

}  // namespace espalier::derivation
