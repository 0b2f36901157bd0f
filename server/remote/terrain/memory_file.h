#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace espalier::server {

/// A file in memory, with the functions by which libtiff reads it.
struct MemoryFile {
  std::string_view bytes;
  std::uint64_t at = 0;

  static std::int64_t read(void* self, void* target, std::int64_t count) {
    auto* const file = static_cast<MemoryFile*>(self);
    const std::uint64_t left = file->at < file->bytes.size() ? file->bytes.size() - file->at : 0;
    const auto taken = static_cast<std::size_t>(
        std::min<std::uint64_t>(left, static_cast<std::uint64_t>(std::max<std::int64_t>(count, 0))));
    if (taken > 0) {
      std::memcpy(target, file->bytes.data() + file->at, taken);
    }
    file->at += taken;
    return static_cast<std::int64_t>(taken);
  }
  static std::int64_t write(void*, void*, std::int64_t) { return 0; }
  static std::uint64_t seek(void* self, std::uint64_t offset, int from) {
    auto* const file = static_cast<MemoryFile*>(self);
    file->at = offset + (from == SEEK_CUR ? file->at : from == SEEK_END ? file->bytes.size() : 0);
    return file->at;
  }
  static int close(void*) { return 0; }
  static std::uint64_t size(void* self) { return static_cast<MemoryFile*>(self)->bytes.size(); }
};

}  // namespace espalier::server
