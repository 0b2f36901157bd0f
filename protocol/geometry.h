#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::protocol {

class BlockWriter;
class Member;
class JsonWriter;
class Payload;

/// The geometry of a step as columns: whole, or the difference from the one sent before. The numbers live in `owner`;
/// when it is null the caller keeps them alive. Rows: s segments, o organs, v vertices, t triangles; of a difference
/// only the new ones.
struct GeometryColumns {
  /// Stands for the first number of a run that takes new rows, not rows of the geometry before.
  static constexpr std::uint32_t kNewRows = 0xFFFFFFFF;

  bool isDifference = false;
  bool areWidthsPixels = false;
  std::vector<std::string> symbols;
  std::span<const std::uint32_t> segmentRuns, organRuns;  // of a difference: first, count, shift of modules (3r)
  std::span<const std::uint32_t> segmentPlant, segmentModule, segmentSymbol, segmentColour, segmentOrder;  // (s)
  std::span<const double> segmentStart, segmentEnd;                                                        // (3s)
  std::span<const double> segmentStartWidth, segmentEndWidth;                                              // (s)
  std::span<const std::uint32_t> organPlant, organModule, organSymbol, organColour, organOrder;            // (o)
  std::span<const std::uint32_t> organKind;                      // cylinder, polygon, surface, patch, ball (o)
  std::span<const std::uint32_t> organVertices, organTriangles;  // how many (o)
  std::span<const double> vertices;                              // (3v)
  std::span<const std::uint32_t> triangles;                      // indices among the organ's own vertices (3t)
  std::shared_ptr<const void> owner;
};

/// The object of the member `geometry`; without its columns when they go in blocks. Throws NonFiniteNumber.
void write(JsonWriter& writer, const GeometryColumns& geometry, bool isInBlocks);
/// Adds the columns. The blocks refer to them until they are sent, except for columns that are narrowed to single
/// precision. Throws NonFiniteNumber.
void addBlocks(BlockWriter& blocks, const GeometryColumns& geometry, bool isSinglePrecision = false);
/// Reads and checks the object `member`; its columns come from the blocks when the message has any. For protocol's own
/// decoders: a mistake is thrown as MemberFailure.
[[nodiscard]] GeometryColumns readGeometry(const Member& member, const Payload& payload);

}  // namespace espalier::protocol
