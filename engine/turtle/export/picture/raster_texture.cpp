#include "engine/turtle/export/picture/raster_texture.h"

#include <algorithm>
#include <cmath>

#include "engine/core/elementary.h"
#include "engine/files/images/image_file.h"

namespace espalier::turtle {

namespace {

std::uint8_t rounded(double value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
}

}  // namespace

RasterTexture::RasterTexture(const files::Texture& texture, const Colour& below)
    : hidesColour_(texture.use != files::Texture::Use::Modulate) {
  const files::Image& image = *texture.image;
  Level full{image.width, image.height, image.pixels};
  const std::array<double, 3> base{static_cast<double>(below.red), static_cast<double>(below.green),
                                   static_cast<double>(below.blue)};
  for (std::size_t at = 0; at < full.pixels.size(); at += 4) {
    const double opacity = full.pixels[at + 3] / 255.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double own = full.pixels[at + k];
      if (texture.use == files::Texture::Use::Decal) {
        full.pixels[at + k] = rounded(opacity * own + (1.0 - opacity) * base[k]);
      } else if (texture.use == files::Texture::Use::Blend) {
        full.pixels[at + k] = rounded(base[k] + own / 255.0 * (255.0 - base[k]));
      } else {
        full.pixels[at + k] = rounded(opacity * own);
      }
    }
    if (hidesColour_) {
      full.pixels[at + 3] = 255;
    }
  }
  levels_.push_back(std::move(full));
  // each level is the one before at half the size; an odd last row or column counts for itself
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level half{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    half.pixels.resize(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height) * 4);
    for (int y = 0; y < half.height; ++y) {
      for (int x = 0; x < half.width; ++x) {
        for (std::size_t k = 0; k < 4; ++k) {
          const auto value = [&](int column, int row) {
            const int atX = std::min(2 * x + column, fine.width - 1);
            const int atY = std::min(2 * y + row, fine.height - 1);
            return static_cast<unsigned>(
                fine.pixels[(static_cast<std::size_t>(atY) * static_cast<std::size_t>(fine.width) +
                             static_cast<std::size_t>(atX)) *
                                4 +
                            k]);
          };
          const unsigned sum = value(0, 0) + value(1, 0) + value(0, 1) + value(1, 1);
          half.pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(half.width) +
                       static_cast<std::size_t>(x)) *
                          4 +
                      k] = static_cast<std::uint8_t>((sum + 2) / 4);
        }
      }
    }
    levels_.push_back(std::move(half));
  }
}

std::size_t RasterTexture::levelOf(double textureArea, double sampleArea) const {
  const double points = textureArea * levels_[0].width * levels_[0].height;
  if (!(points > sampleArea) || !(sampleArea > 0.0)) {
    return 0;
  }
  const double level = 0.5 * core::log2(points / sampleArea);
  return std::min(static_cast<std::size_t>(level + 0.5), levels_.size() - 1);
}

std::array<float, 4> RasterTexture::at(double u, double v, std::size_t level) const {
  const Level& picture = levels_[level];
  if (!std::isfinite(u + v)) {
    return {0.0F, 0.0F, 0.0F, 1.0F};
  }
  // the row of points above and the column to the left of the place, and how far it is beyond them
  const double x = (u - std::floor(u)) * picture.width - 0.5;
  const double y = (1.0 - (v - std::floor(v))) * picture.height - 0.5;
  const double left = std::floor(x);
  const double upper = std::floor(y);
  const auto wrapped = [](double index, int count) {
    const int i = static_cast<int>(index);
    return static_cast<std::size_t>(i < 0 ? i + count : (i >= count ? i - count : i));
  };
  const std::array<std::size_t, 2> columns{wrapped(left, picture.width), wrapped(left + 1.0, picture.width)};
  const std::array<std::size_t, 2> rows{wrapped(upper, picture.height), wrapped(upper + 1.0, picture.height)};
  const std::array<float, 2> alongX{static_cast<float>(1.0 - (x - left)), static_cast<float>(x - left)};
  const std::array<float, 2> alongY{static_cast<float>(1.0 - (y - upper)), static_cast<float>(y - upper)};
  std::array<float, 4> sum{};
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::uint8_t* const point =
          &picture.pixels[(rows[j] * static_cast<std::size_t>(picture.width) + columns[i]) * 4];
      const float weight = alongX[i] * alongY[j] / 255.0F;
      for (std::size_t k = 0; k < 4; ++k) {
        sum[k] += weight * static_cast<float>(point[k]);
      }
    }
  }
  // the colour itself, without its opacity
  for (std::size_t k = 0; k < 3 && sum[3] > 0.0F; ++k) {
    sum[k] = std::min(1.0F, sum[k] / sum[3]);
  }
  return sum;
}

}  // namespace espalier::turtle
