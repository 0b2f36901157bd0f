#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::server {

/// The type of the numbers of one band of a GeoTIFF, and which of them are no heights.
struct HeightBand {
  std::uint16_t bits = 1;        // of a number: 1 (of a mask), 8, 16, 32 or 64
  bool isReal = false;           // 32 or 64 bits
  bool isSigned = false;         // of whole numbers
  std::optional<double> noData;  // stands for no height; as a number of the file, before scale and offset
  double scale = 1.0, offset = 0.0;

  /// Bytes of so many numbers in a row.
  [[nodiscard]] std::size_t bytesOf(std::size_t count) const { return (count * bits + 7) / 8; }

  /// The number at a place of a row of decoded bytes.
  [[nodiscard]] double numberAt(const char* row, std::size_t index) const;

  /// Takes the text of GDAL's tag 42113, as `-3.4028235e+38`. A real number of 32 bits is rounded as those of the file
  /// are, since the text has fewer digits than they. A text that is no number says nothing.
  void takeNoData(std::string_view text);

  /// Takes GDAL's metadata (tag 42112), as `<Item name="SCALE" sample="0" role="scale">0.01</Item>`: scale and offset.
  /// A sentence when the unit of the heights is not the metre; no unit counts as the metre.
  [[nodiscard]] std::optional<std::string> takeMetadata(std::string_view items);

  /// Applies scale and offset. A sentence when cells are without a height (the no-data value, or no finite number).
  [[nodiscard]] std::optional<std::string> finish(std::vector<double>& heights) const;
};

}  // namespace espalier::server
