#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/core/byte_source.h"
#include "engine/core/streams.h"
#include "server/remote/disk_room.h"

namespace espalier::server {

/// A file that is written while a run goes on, compressed (zstd) when its name ends in `.zst`. After flush() the
/// written part is readable, even if the program is killed.
class TraceFile final : public core::ByteSink {
 public:
  /// An error sentence when the file cannot be made. `room`: that the file shares with others, and outlives it; null:
  /// none.
  [[nodiscard]] static tl::expected<std::unique_ptr<TraceFile>, std::string> create(const std::string& name,
                                                                                    DiskRoom* room = nullptr);
  ~TraceFile() override;
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  /// A failure is kept for close(): a full disk does not end the run.
  void write(std::string_view bytes) override;
  void flush();
  /// A sentence when anything could not be written; else empty.
  [[nodiscard]] std::string problem() const;
  /// The room that did not have enough; null: that is not the problem.
  [[nodiscard]] const DiskRoom* outOfRoom() const { return outOfRoom_; }
  /// Memory of the compression.
  [[nodiscard]] std::uint64_t memoryBytes() const;
  /// Ends the file. Then the room has counted as many bytes as the file has: a file is removed after that. An error
  /// sentence when anything could not be written.
  [[nodiscard]] std::optional<std::string> close();

 private:
  struct Compressor;
  TraceFile(std::string name, std::FILE* file, bool isCompressed, DiskRoom* room);
  void put(std::string_view bytes);
  void compress(std::string_view bytes, int directive);

  std::string name_;
  std::FILE* file_;                         // null: closed
  DiskRoom* room_;                          // null: none
  std::uint64_t takenBytes_ = 0;            // of the room
  const DiskRoom* outOfRoom_ = nullptr;     // null: there was enough
  std::unique_ptr<Compressor> compressor_;  // null: none
  std::string problem_;
};

/// Reads a trace piece by piece, decompressed where needed, in a few megabytes of memory: a few bytes can stand for
/// terabytes. The end of a file that a killed program has left is where its last flush() was. Error sentences name the
/// file.
class TraceFileSource final : public core::ByteSource {
 public:
  /// An error sentence when the file cannot be opened.
  [[nodiscard]] static tl::expected<std::unique_ptr<TraceFileSource>, std::string> open(const std::string& name);
  ~TraceFileSource() override;
  TraceFileSource(const TraceFileSource&) = delete;
  TraceFileSource& operator=(const TraceFileSource&) = delete;

  [[nodiscard]] std::optional<std::string> read(std::size_t count, std::string& bytes) override;

 private:
  struct Decompressor;
  TraceFileSource(std::string name, std::FILE* file);
  /// Puts the next bytes of the file, or of what it stands for, into piece_; none at the end.
  [[nodiscard]] std::optional<std::string> fill();
  [[nodiscard]] std::optional<std::string> fillFromFile(std::string& piece);

  std::string name_;
  std::FILE* file_;
  std::unique_ptr<Decompressor> decompressor_;  // null: not compressed
  std::string piece_;
  std::size_t given_ = 0;  // bytes of piece_ that were given
};

/// How long an event of a trace may be unless the user says more: 256 MB, or a quarter of the memory that this process
/// may have when that is less.
[[nodiscard]] std::uint64_t maximumTraceEventBytes();

}  // namespace espalier::server
