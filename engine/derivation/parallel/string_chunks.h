#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/derivation/batch/type_sum.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// The chunks of a string that several threads scan: pieces of equal length, and where the parameters of each begin.
class StringChunks {
 public:
  explicit StringChunks(const language::Program& program);

  /// Cuts `string` into chunks of `chunkModules` modules. Links the brackets of the string too, unless `links` is null.
  /// O(modules), shared by the team.
  void cut(const ModuleString& string, std::uint64_t chunkModules, core::WorkerTeam& team, StringIndex* links);

  [[nodiscard]] std::uint64_t count() const { return offsets_.size() - 1; }
  [[nodiscard]] std::uint64_t chunkModules() const { return chunkModules_; }
  /// The first module of a chunk. `chunk` may be count(): the end of the string.
  [[nodiscard]] ScanPlace begin(std::uint64_t chunk) const {
    const std::uint64_t first = chunk * chunkModules_;
    return {first < size_ ? first : size_, offsets_[chunk]};
  }

 private:
  TypeSum parameterSum_;
  std::uint64_t size_ = 0;  // modules of the string
  std::uint64_t chunkModules_ = 1;
  std::vector<std::uint64_t> offsets_{0};        // by chunk: its first parameter; then the end (count + 1)
  std::vector<StringIndex::OpenEnds> openEnds_;  // by part of the string; more when an earlier string had more
};

}  // namespace espalier::derivation
