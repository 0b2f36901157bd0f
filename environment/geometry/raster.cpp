#include "environment/geometry/raster.h"

#include <limits>
#include <utility>

#include "environment/base/image_of_line.h"

namespace espalier::environment {

namespace {

/// A map as rows from the far edge to the near one, spread over the raster's cells.
std::vector<double> spread(const ConfigurationRows& rows, const RasterShape& shape, PixelOfCell pixelOfCell,
                           double otherwise) {
  const auto [columnCount, rowCount] = shape.cells;
  std::vector<double> cells(shape.cellCount(), otherwise);
  if (rows.empty()) {
    return cells;
  }
  for (std::size_t y = 0; y < rowCount; ++y) {
    const auto& row = rows[rows.size() - 1 - pixelOfCell(y, rowCount, rows.size())];
    for (std::size_t x = 0; x < columnCount; ++x) {
      cells[y * columnCount + x] = row[pixelOfCell(x, columnCount, row.size())];
    }
  }
  return cells;
}

std::size_t pixelUnderCell(std::size_t cell, std::size_t cellCount, std::size_t pixelCount) {
  return cell * pixelCount / cellCount;
}

/// One channel of an image, as rows from the far edge to the near one.
ConfigurationRows channelOf(const files::Image& image, int channel) {
  ConfigurationRows rows(static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      rows[static_cast<std::size_t>(y)].push_back(image.at(x, y, channel));
    }
  }
  return rows;
}

}  // namespace

RasterShape rasterShapeOf(const Configuration& configuration) {
  const auto pairOf = [&](std::string_view key) {
    return std::array{configuration.numbers(key)[0], configuration.numbers(key)[1]};
  };
  const auto [columns, rows] = pairOf("gridSize");
  return {planeNamed(configuration.text("plane")),
          pairOf("position"),
          pairOf("range"),
          {static_cast<std::size_t>(columns), static_cast<std::size_t>(rows)}};
}

Bounds RasterShape::box() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 2> high{position[0] + range[0], position[1] + range[1]};
  switch (plane) {
    case Plane::Xy:
      return {{position[0], position[1], -kInfinity}, {high[0], high[1], kInfinity}};
    case Plane::Yz:
      return {{-kInfinity, position[0], position[1]}, {kInfinity, high[0], high[1]}};
    default:
      return {{position[0], -kInfinity, position[1]}, {high[0], kInfinity, high[1]}};
  }
}

RasterMaps rasterMapsOf(const Configuration& configuration, const RasterShape& shape, PixelOfCell pixelOfCell) {
  return {spread(configuration.rows("lightMap"), shape, pixelOfCell, 255.0),
          spread(configuration.rows("secondMap"), shape, pixelOfCell, 0.0)};
}

std::vector<core::Diagnostic> problemsOfRaster(std::string_view process, const Configuration& configuration) {
  std::vector<core::Diagnostic> problems;
  for (const char* const key : {"lightMap", "secondMap"}) {
    const ConfigurationRows& rows = configuration.rows(key);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (rows[i].size() != rows[0].size()) {
        problems.push_back(wrongConfiguration(process,
                                              "'" + std::string(key) + "[" + std::to_string(i) + "]' must have " +
                                                  std::to_string(rows[0].size()) +
                                                  " numbers as the row before, found " + std::to_string(rows[i].size()),
                                              "all rows of a map have one length"));
        break;
      }
    }
  }
  return problems;
}

Raster::Raster(const Configuration& configuration)
    : shape_(rasterShapeOf(configuration)), maps_(rasterMapsOf(configuration, shape_, pixelUnderCell)) {}

std::array<double, 2> Raster::cellsOf(const core::Vec3& point) const {
  const auto [across, along] = shape_.flat(point);
  return {(across - shape_.position[0]) * static_cast<double>(shape_.cells[0]) / shape_.range[0],
          (along - shape_.position[1]) * static_cast<double>(shape_.cells[1]) / shape_.range[1]};
}

std::optional<std::size_t> Raster::cellOf(const core::Vec3& point) const {
  const auto [across, along] = cellsOf(point);
  if (!(across >= 0.0 && along >= 0.0 && across < static_cast<double>(shape_.cells[0]) &&
        along < static_cast<double>(shape_.cells[1]))) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(along) * shape_.cells[0] + static_cast<std::size_t>(across);
}

std::string readInputImage(const PublishedLineInput& input) {
  const auto image = readImageBeside(input, input.line.value);
  if (!image) {
    return image.error();
  }
  input.values.insert_or_assign("lightMap", channelOf(*image, 1));
  input.values.insert_or_assign("secondMap", channelOf(*image, 0));
  return {};
}

std::string readUpAxis(const PublishedLineInput& input) {
  const std::string_view word = firstPublishedWord(input.line.value);
  const bool isUp = word != "no" && word != "off";
  if (isUp && word != "yes" && word != "on") {
    input.dropped = "is switched off only by 'no' or 'off': taken as yes";
  }
  input.values.insert_or_assign("plane", std::string(isUp ? "xy" : "xz"));
  return {};
}

}  // namespace espalier::environment
