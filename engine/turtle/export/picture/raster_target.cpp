#include "engine/turtle/export/picture/raster_target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace espalier::turtle {

namespace {

constexpr int kAcross = RasterTarget::kSamplesAcross;

// an ordered dither of the sixteen samples of a pixel (Bayer 1973)
constexpr std::array<int, 16> kOrder{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};

std::uint32_t mixedBits(std::uint32_t x) {
  x ^= x >> 16U;
  x *= 0x7feb352dU;
  x ^= x >> 15U;
  x *= 0x846ca68bU;
  return x ^ (x >> 16U);
}

/// A quantity that is linear over the page.
struct Plane {
  double atOrigin = 0.0;
  double alongX = 0.0;
  double alongY = 0.0;
  double low = 0.0;  // its extremes over the triangle: samples of a sliver must not go beyond
  double high = 0.0;
};

/// Corners in samples, relative to the first one, whose area is not zero.
struct Corners {
  std::array<double, 3> x, y;
  double area = 0.0;
};

Plane planeThrough(const Corners& corners, double a, double b, double c) {
  Plane plane;
  const double db = b - a;
  const double dc = c - a;
  const double x1 = corners.x[1] - corners.x[0];
  const double y1 = corners.y[1] - corners.y[0];
  const double x2 = corners.x[2] - corners.x[0];
  const double y2 = corners.y[2] - corners.y[0];
  plane.alongX = (db * y2 - dc * y1) / corners.area;
  plane.alongY = (dc * x1 - db * x2) / corners.area;
  plane.atOrigin = a - plane.alongX * corners.x[0] - plane.alongY * corners.y[0];
  plane.low = std::min({a, b, c});
  plane.high = std::max({a, b, c});
  return plane;
}

// clamped first, so that the whole part is a plain conversion
int clampedFloor(double value, int low, int high) {
  const double inside = std::clamp(value, static_cast<double>(low), static_cast<double>(high));
  const int whole = static_cast<int>(inside);
  return whole - (static_cast<double>(whole) > inside ? 1 : 0);
}

int clampedCeil(double value, int low, int high) {
  const double inside = std::clamp(value, static_cast<double>(low), static_cast<double>(high));
  const int whole = static_cast<int>(inside);
  return whole + (static_cast<double>(whole) < inside ? 1 : 0);
}

/// An edge of a triangle, downward. Both triangles at an edge compute alike where it crosses a row of sample centres.
class Edge {
 public:
  Edge(const Corners& corners, std::size_t from, std::size_t to)
      : x_(corners.x[from]),
        y_(corners.y[from]),
        width_(corners.x[to] - corners.x[from]),
        height_(corners.y[to] - corners.y[from]) {}
  /// For rows that the edge crosses: its height is above 0.
  [[nodiscard]] double xAt(double y) const { return x_ + width_ * ((y - y_) / height_); }

 private:
  double x_, y_, width_, height_;
};

/// Samples of a row: `begin` to `end - 1`. Without initial values: a triangle has few of 256 rows.
struct SampleSpan {
  int begin;
  int end;
};

/// The samples of one tile: columns `left` to `right - 1` and rows `upper` to `lower - 1` of the page.
struct TileSamples {
  int left, right, upper, lower;
};

/// Which samples of a tile lie in a triangle, row by row. All rows are found before the first is drawn: the divisions
/// take longer than the rest.
class RowSpans {
 public:
  RowSpans(const Corners& corners, const TileSamples& tile) : tile_(tile) {
    const auto [first, middle, last] = downward(corners);
    // a sample belongs to the triangle when its centre does; on an edge it belongs to the right and lower neighbour
    begin_ = clampedCeil(corners.y[first] - 0.5, tile.upper, tile.lower);
    end_ = clampedCeil(corners.y[last] - 0.5, tile.upper, tile.lower);
    const int bend = clampedCeil(corners.y[middle] - 0.5, begin_, end_);
    const Edge longest(corners, first, last);
    find(longest, Edge(corners, first, middle), begin_, bend);
    find(longest, Edge(corners, middle, last), bend, end_);
  }
  [[nodiscard]] int begin() const { return begin_; }
  [[nodiscard]] int end() const { return end_; }
  [[nodiscard]] const SampleSpan& of(int row) const { return spans_[static_cast<std::size_t>(row - tile_.upper)]; }

 private:
  // the corners from top to bottom
  static std::array<std::size_t, 3> downward(const Corners& corners) {
    std::array<std::size_t, 3> order{0, 1, 2};
    const auto putInOrder = [&](std::size_t& i, std::size_t& j) {
      if (corners.y[j] != corners.y[i] ? corners.y[j] < corners.y[i] : corners.x[j] < corners.x[i]) {
        std::swap(i, j);
      }
    };
    putInOrder(order[0], order[1]);
    putInOrder(order[1], order[2]);
    putInOrder(order[0], order[1]);
    return order;
  }

  void find(const Edge& longest, const Edge& other, int firstRow, int endRow) {
    for (int row = firstRow; row < endRow; ++row) {
      const double y = row + 0.5;
      const auto [left, right] = std::minmax({longest.xAt(y), other.xAt(y)});
      spans_[static_cast<std::size_t>(row - tile_.upper)] = {clampedCeil(left - 0.5, tile_.left, tile_.right),
                                                             clampedCeil(right - 0.5, tile_.left, tile_.right)};
    }
  }

  TileSamples tile_;
  int begin_ = 0;
  int end_ = 0;
  std::array<SampleSpan, RasterTarget::kTileSamples> spans_;  // those of begin_ to end_ - 1 have values
};

}  // namespace

RasterTarget::RasterTarget(int width, int firstRow, int rows)
    : width_(width), firstRow_(firstRow), rows_(rows), isDrawn_(tileNumber(0, tileRows()), 0) {
  // a tile gets its values when something is drawn there, by the thread that draws: most of a page is often empty
  const std::size_t samples = tileNumber(0, rows * kAcross) * kTileSamples;
  nearness_.resize(samples);
  colours_.resize(samples);
}

std::array<int, 4> RasterTarget::tilesOf(const RasterTriangle& triangle) const {
  const auto& [a, b, c] = triangle.corners;
  const double left = std::min({a.x, b.x, c.x});
  const double right = std::max({a.x, b.x, c.x});
  const double upper = static_cast<double>(std::min({a.y, b.y, c.y})) - firstRow_;
  const double lower = static_cast<double>(std::max({a.y, b.y, c.y})) - firstRow_;
  if (!(right >= 0.0 && left <= width_ && lower >= 0.0 && upper <= rows_)) {
    return {1, 0, 1, 0};
  }
  // no centre of a sample between the edges; where an edge crosses a row is known up to rounding
  const double slack = 1e-12 * (std::abs(left) + std::abs(right));
  const auto firstBehind = [](double pixel) { return std::ceil(pixel * kAcross - 0.5); };
  if (firstBehind(upper) >= firstBehind(lower) || firstBehind(left - slack) >= firstBehind(right + slack)) {
    return {1, 0, 1, 0};
  }
  const auto tile = [](double pixel, int count) { return clampedFloor(pixel / kTilePixels, 0, count - 1); };
  return {tile(left, tileColumns()), tile(right, tileColumns()), tile(upper, tileRows()), tile(lower, tileRows())};
}

void RasterTarget::draw(const RasterTriangle& triangle, int tileColumn, int tileRow) {
  Corners corners;
  for (std::size_t i = 0; i < 3; ++i) {
    corners.x[i] = static_cast<double>(triangle.corners[i].x) * kAcross;
    corners.y[i] = (static_cast<double>(triangle.corners[i].y) - firstRow_) * kAcross;
  }
  corners.area = (corners.x[1] - corners.x[0]) * (corners.y[2] - corners.y[0]) -
                 (corners.x[2] - corners.x[0]) * (corners.y[1] - corners.y[0]);
  if (!(std::abs(corners.area) > 0.0) || !std::isfinite(corners.area)) {
    return;
  }
  const int left = tileColumn * kTilePixels * kAcross;
  const int right = std::min(left + kTileSamples, width_ * kAcross);
  const int upper = tileRow * kTilePixels * kAcross;
  const int lower = upper + sampleRows(tileRow);
  const RowSpans spans(corners, {left, right, upper, lower});

  const auto& v = triangle.corners;
  const Plane nearness = planeThrough(corners, static_cast<double>(v[0].nearness), static_cast<double>(v[1].nearness),
                                      static_cast<double>(v[2].nearness));
  // most triangles of a large plant are hidden or have one colour: planes of colours are made for the first sample that
  // needs them
  std::array<Plane, 3> channels;
  bool hasChannels = false;
  const auto makeChannels = [&] {
    for (std::size_t k = 0; k < 3 && !hasChannels; ++k) {
      channels[k] = planeThrough(corners, static_cast<double>(v[0].colour[k]), static_cast<double>(v[1].colour[k]),
                                 static_cast<double>(v[2].colour[k]));
    }
    hasChannels = true;
  };
  bool isPlain = v[0].colour == v[1].colour && v[1].colour == v[2].colour;
  const auto colourAt = [&](double x, double y) {
    makeChannels();
    std::uint32_t colour = 0xFF000000U;
    for (std::size_t k = 0; k < 3; ++k) {
      const Plane& c = channels[k];
      const double value = std::clamp(c.atOrigin + c.alongX * x + c.alongY * y, c.low, c.high);
      colour |= static_cast<std::uint32_t>(value + 0.5) << (8U * static_cast<unsigned>(k));
    }
    return colour;
  };
  // texture coordinates, and the size at which the picture is looked at
  std::array<Plane, 3> place;
  std::size_t level = 0;
  if (triangle.texture != nullptr) {
    place[0] =
        planeThrough(corners, static_cast<double>(v[0].u), static_cast<double>(v[1].u), static_cast<double>(v[2].u));
    place[1] =
        planeThrough(corners, static_cast<double>(v[0].v), static_cast<double>(v[1].v), static_cast<double>(v[2].v));
    place[2] = planeThrough(corners, static_cast<double>(v[0].share), static_cast<double>(v[1].share),
                            static_cast<double>(v[2].share));
    std::array<std::array<double, 2>, 3> uv;
    for (std::size_t i = 0; i < 3; ++i) {
      const double share = static_cast<double>(v[i].share);
      uv[i] = {static_cast<double>(v[i].u) / share, static_cast<double>(v[i].v) / share};
    }
    const double textureArea =
        (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) - (uv[2][0] - uv[0][0]) * (uv[1][1] - uv[0][1]);
    level = triangle.texture->levelOf(std::abs(textureArea), std::abs(corners.area));
    isPlain = false;
  }
  // the colour with the texture's at a sample; 0 in a hole
  const auto wornAt = [&](double x, double y) -> std::uint32_t {
    const auto value = [&](const Plane& plane) { return plane.atOrigin + plane.alongX * x + plane.alongY * y; };
    const double share = std::clamp(value(place[2]), place[2].low, place[2].high);
    const std::array<float, 4> worn =
        triangle.texture->at(std::clamp(value(place[0]), place[0].low, place[0].high) / share,
                             std::clamp(value(place[1]), place[1].low, place[1].high) / share, level);
    if (worn[3] < 0.5F) {
      return 0;
    }
    makeChannels();
    std::uint32_t colour = 0xFF000000U;
    for (std::size_t k = 0; k < 3; ++k) {
      const double below = std::clamp(value(channels[k]), channels[k].low, channels[k].high);
      colour |= static_cast<std::uint32_t>(below * static_cast<double>(worn[k]) + 0.5)
                << (8U * static_cast<unsigned>(k));
    }
    return colour;
  };
  std::uint32_t plainColour = 0xFF000000U;
  for (std::size_t k = 0; k < 3; ++k) {
    plainColour |= static_cast<std::uint32_t>(static_cast<double>(v[0].colour[k]) + 0.5)
                   << (8U * static_cast<unsigned>(k));
  }
  const std::uint32_t pattern = mixedBits(triangle.organ) & 15U;
  const double coverage = static_cast<double>(triangle.opacity) * 16.0;
  const auto isCovered = [&](int x, int y) {
    const auto sample = static_cast<std::uint32_t>((y & 3) * 4 + (x & 3));
    return kOrder[sample ^ pattern] + 0.5 < coverage;
  };

  const std::size_t tileStart = firstSample(tileColumn, tileRow);
  float* const samplesNearness = nearness_.data() + tileStart;
  std::uint32_t* const samplesColour = colours_.data() + tileStart;
  if (std::uint8_t& isDrawn = isDrawn_[tileNumber(tileColumn, tileRow)]; isDrawn == 0) {
    const std::size_t samples = static_cast<std::size_t>(sampleRows(tileRow)) * kTileSamples;
    std::fill_n(samplesNearness, samples, -std::numeric_limits<float>::infinity());
    std::fill_n(samplesColour, samples, 0U);
    isDrawn = 1;
  }
  for (int row = spans.begin(); row < spans.end(); ++row) {
    const double y = row + 0.5;
    const auto [beginX, endX] = spans.of(row);
    const std::size_t rowStart = static_cast<std::size_t>(row - upper) * kTileSamples;
    const double rowNearness = nearness.atOrigin + nearness.alongY * y;
    for (int x = beginX; x < endX; ++x) {
      const double centre = x + 0.5;
      const auto near =
          static_cast<float>(std::clamp(rowNearness + nearness.alongX * centre, nearness.low, nearness.high));
      const std::size_t at = rowStart + static_cast<std::size_t>(x - left);
      if (near < samplesNearness[at] || (coverage < 16.0 && !isCovered(x, row))) {
        continue;
      }
      const std::uint32_t colour =
          isPlain ? plainColour : (triangle.texture != nullptr ? wornAt(centre, y) : colourAt(centre, y));
      if (colour == 0) {
        continue;
      }
      samplesNearness[at] = near;
      samplesColour[at] = colour;
    }
  }
}

void RasterTarget::resolve(int row, const Colour& background, bool isTransparent, std::span<std::uint8_t> pixels,
                           std::span<const float> shades) const {
  constexpr std::uint32_t kSampleCount = kAcross * kAcross;
  const std::array<std::uint32_t, 3> page{background.red, background.green, background.blue};
  const int tileRow = row / kTilePixels;
  for (int column = 0; column < width_; ++column) {
    std::array<std::uint32_t, 4> sum{};
    const int tileColumn = column / kTilePixels;
    const std::size_t first =
        firstSample(tileColumn, tileRow) +
        static_cast<std::size_t>((row % kTilePixels) * kAcross * kTileSamples + (column % kTilePixels) * kAcross);
    const int drawnRows = isDrawn_[tileNumber(tileColumn, tileRow)] != 0 ? kAcross : 0;
    for (int i = 0; i < drawnRows; ++i) {
      const std::size_t at = first + static_cast<std::size_t>(i * kTileSamples);
      for (std::size_t j = 0; j < kAcross; ++j) {
        const std::uint32_t colour = colours_[at + j];
        for (unsigned k = 0; k < 4; ++k) {
          sum[k] += (colour >> (8U * k)) & 255U;
        }
      }
    }
    const std::uint32_t drawn = sum[3] / 255U;  // samples
    std::uint8_t* pixel = &pixels[static_cast<std::size_t>(column) * 4];
    for (std::size_t k = 0; k < 3; ++k) {
      // colours are not multiplied by the opacity in a PNG
      const std::uint32_t divisor = isTransparent ? drawn : kSampleCount;
      const float light = shades.empty() ? 1.0F : 1.0F - shades[static_cast<std::size_t>(column)];
      const auto behind = static_cast<std::uint32_t>(static_cast<float>((kSampleCount - drawn) * page[k]) * light);
      const std::uint32_t total = isTransparent ? sum[k] : sum[k] + behind;
      pixel[k] = static_cast<std::uint8_t>(divisor == 0 ? 0 : (total + divisor / 2) / divisor);
    }
    pixel[3] = isTransparent ? static_cast<std::uint8_t>(sum[3] / kSampleCount) : std::uint8_t{255};
  }
}

}  // namespace espalier::turtle
