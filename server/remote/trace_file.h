#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/core/streams.h"

namespace espalier::server {

/// A file that is written while a run goes on, compressed (zstd) when its name ends in `.zst`. After flush() the
/// written part is readable, even if the program is killed.
class TraceFile final : public core::ByteSink {
 public:
  /// An error sentence when the file cannot be made.
  [[nodiscard]] static tl::expected<std::unique_ptr<TraceFile>, std::string> create(const std::string& name);
  ~TraceFile() override;
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  /// A failure is kept for close(): a full disk does not end the run.
  void write(std::string_view bytes) override;
  void flush();
  /// A sentence when anything could not be written; else empty.
  [[nodiscard]] std::string problem() const;
  /// Ends the file. An error sentence when anything could not be written.
  [[nodiscard]] std::optional<std::string> close();

 private:
  struct Compressor;
  TraceFile(std::string name, std::FILE* file, bool isCompressed);
  void put(std::string_view bytes);
  void compress(std::string_view bytes, int directive);

  std::string name_;
  std::FILE* file_;                         // null: closed
  std::unique_ptr<Compressor> compressor_;  // null: none
  std::string problem_;
};

/// Reads a trace into `bytes`, decompressed where needed. An error sentence, or nothing. A few bytes can stand for
/// terabytes: `bound` is of the decompressed ones; 0: the memory that this process may have.
[[nodiscard]] std::optional<std::string> readTraceFile(const std::string& name, std::string& bytes,
                                                       std::uint64_t bound = 0);

}  // namespace espalier::server
