#include "environment/geometry/raster.h"

#include <utility>

#include "environment/base/image_of_line.h"

namespace espalier::environment {

namespace {

/// A map as rows from the far edge to the near one, spread over the raster's cells.
std::vector<double> spread(const ConfigurationRows& rows, std::size_t columnCount, std::size_t rowCount,
                           double otherwise) {
  std::vector<double> cells(columnCount * rowCount, otherwise);
  if (rows.empty()) {
    return cells;
  }
  for (std::size_t y = 0; y < rowCount; ++y) {
    const auto& row = rows[rows.size() - 1 - y * rows.size() / rowCount];
    for (std::size_t x = 0; x < columnCount; ++x) {
      cells[y * columnCount + x] = row[x * row.size() / columnCount];
    }
  }
  return cells;
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

Raster::Raster(const Configuration& configuration)
    : plane_(planeNamed(configuration.text("plane"))),
      position_{configuration.numbers("position")[0], configuration.numbers("position")[1]},
      range_{configuration.numbers("range")[0], configuration.numbers("range")[1]},
      columnCount_(static_cast<std::size_t>(configuration.numbers("gridSize")[0])),
      rowCount_(static_cast<std::size_t>(configuration.numbers("gridSize")[1])),
      light_(spread(configuration.rows("lightMap"), columnCount_, rowCount_, 255.0)),
      second_(spread(configuration.rows("secondMap"), columnCount_, rowCount_, 0.0)) {}

std::vector<core::Diagnostic> Raster::problemsOf(std::string_view process, const Configuration& configuration) {
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

Raster::Flat Raster::cellsOf(const core::Vec3& point) const {
  const double across = plane_ == Plane::Yz ? point.y : point.x;
  const double along = plane_ == Plane::Xy ? point.y : point.z;
  return {(across - position_[0]) * static_cast<double>(columnCount_) / range_[0],
          (along - position_[1]) * static_cast<double>(rowCount_) / range_[1]};
}

std::optional<std::size_t> Raster::cellOf(const core::Vec3& point) const {
  const Flat cells = cellsOf(point);
  if (!(cells.across >= 0.0 && cells.along >= 0.0 && cells.across < static_cast<double>(columnCount_) &&
        cells.along < static_cast<double>(rowCount_))) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(cells.along) * columnCount_ + static_cast<std::size_t>(cells.across);
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
  const bool isUp = input.line.value == "yes" || input.line.value == "on";
  input.values.insert_or_assign("plane", std::string(isUp ? "xy" : "xz"));
  return {};
}

}  // namespace espalier::environment
