#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "engine/core/hash.h"
#include "engine/core/streams.h"
#include "engine/simulation/byte_writer.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/snapshot_content.h"

// Snapshots as a stranger would make them: wrong inside, with a checksum that agrees.
namespace espalier::simulation {

inline std::string snapshotOf(const Simulation& simulation) {
  core::StringSink sink;
  simulation.save(sink);
  return sink.take();
}

/// The bytes with the last eight replaced by the checksum of those before.
inline std::string withChecksum(std::string_view bytes) {
  const std::string_view checked = bytes.substr(0, bytes.size() < 8 ? 0 : bytes.size() - 8);
  core::Hasher hasher;
  hasher.bytes(checked);
  ByteWriter writer;
  writer.raw(checked);
  writer.number64(hasher.value());
  return writer.bytes();
}

/// The snapshot with `change` made to its content.
inline std::string crafted(std::string_view snapshot, const std::function<void(SnapshotContent&)>& change) {
  auto read = readSnapshot(snapshot, false);
  EXPECT_TRUE(read.has_value());
  if (!read.has_value()) {
    return {};
  }
  SnapshotContent& content = *read;
  change(content);
  core::StringSink sink;
  writeSnapshot(content, sink);
  return sink.take();
}

}  // namespace espalier::simulation
