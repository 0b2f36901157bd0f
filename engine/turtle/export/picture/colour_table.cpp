#include "engine/turtle/export/picture/colour_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "engine/core/check.h"

namespace espalier::turtle {

namespace {

using Channels = std::array<int, 3>;

struct Counted {
  Channels channels{};
  std::uint64_t count = 0;
};

std::uint32_t packed(const std::uint8_t* pixel) {
  return static_cast<std::uint32_t>(pixel[0]) << 16U | static_cast<std::uint32_t>(pixel[1]) << 8U | pixel[2];
}

/// Some of the picture's colours that are to become one.
struct Box {
  std::span<Counted> colours;
  std::array<double, 3> mean{};
  double error = 0.0;      // squared, of all points
  std::size_t widest = 0;  // channel with the largest part of it
};

Box boxOf(std::span<Counted> colours) {
  Box box{.colours = colours};
  std::array<double, 3> sum{};
  std::array<double, 3> squares{};
  double count = 0.0;
  for (const Counted& colour : colours) {
    const auto weight = static_cast<double>(colour.count);
    count += weight;
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] += weight * colour.channels[k];
      squares[k] += weight * colour.channels[k] * colour.channels[k];
    }
  }
  double largest = -1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    box.mean[k] = sum[k] / count;
    const double error = squares[k] - sum[k] * box.mean[k];
    box.error += error;
    if (error > largest) {
      largest = error;
      box.widest = k;
    }
  }
  return box;
}

std::vector<Counted> countColours(const PictureImage& image) {
  std::vector<std::uint32_t> points;
  points.reserve(image.pixels.size() / 4);
  for (std::size_t at = 0; at < image.pixels.size(); at += 4) {
    points.push_back(packed(&image.pixels[at]));
  }
  std::sort(points.begin(), points.end());
  std::vector<Counted> colours;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 0 || points[i] != points[i - 1]) {
      const std::uint32_t c = points[i];
      colours.push_back(
          {{static_cast<int>(c >> 16U), static_cast<int>(c >> 8U & 255U), static_cast<int>(c & 255U)}, 0});
    }
    ++colours.back().count;
  }
  return colours;
}

std::uint8_t nearest(const std::vector<Colour>& colours, const std::uint8_t* pixel) {
  std::size_t best = 0;
  int smallest = 1 << 30;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const int r = colours[i].red - pixel[0];
    const int g = colours[i].green - pixel[1];
    const int b = colours[i].blue - pixel[2];
    const int distance = r * r + g * g + b * b;
    if (distance < smallest) {
      smallest = distance;
      best = i;
    }
  }
  return static_cast<std::uint8_t>(best);
}

}  // namespace

IndexedPicture indexedPicture(const PictureImage& image, int maximumColours) {
  ESPALIER_CHECK(maximumColours >= 2 && maximumColours <= 256);
  std::vector<Counted> counted = countColours(image);
  std::vector<Box> boxes;
  if (!counted.empty()) {
    boxes.push_back(boxOf(counted));
  }
  while (static_cast<int>(boxes.size()) < maximumColours) {
    const auto worst =
        std::max_element(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) { return a.error < b.error; });
    if (worst == boxes.end() || worst->colours.size() < 2) {
      break;
    }
    const Box box = *worst;
    const auto middle = std::stable_partition(box.colours.begin(), box.colours.end(), [&](const Counted& colour) {
      return colour.channels[box.widest] < box.mean[box.widest];
    });
    const auto lower = static_cast<std::size_t>(middle - box.colours.begin());
    if (lower == 0 || lower == box.colours.size()) {
      break;
    }
    *worst = boxOf(box.colours.first(lower));
    boxes.push_back(boxOf(box.colours.subspan(lower)));
  }

  IndexedPicture result;
  for (const Box& box : boxes) {
    const auto channel = [&](std::size_t k) { return static_cast<unsigned char>(std::lround(box.mean[k])); };
    result.colours.push_back({channel(0), channel(1), channel(2)});
  }
  // a point like the one before it needs no search
  result.indices.reserve(image.pixels.size() / 4);
  for (std::size_t at = 0; at < image.pixels.size(); at += 4) {
    const bool isRepeated = at > 0 && packed(&image.pixels[at]) == packed(&image.pixels[at - 4]);
    result.indices.push_back(isRepeated ? result.indices.back() : nearest(result.colours, &image.pixels[at]));
  }
  return result;
}

}  // namespace espalier::turtle
