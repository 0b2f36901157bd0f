#include "environment/output/field_picture.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/turtle/export/picture/bitmap_font.h"

namespace espalier::environment {

using files::Image;

namespace {

// pixels
constexpr int kLetterScale = 2;
constexpr int kLetterWidth = 6 * kLetterScale;
constexpr int kLetterHeight = turtle::kLetterRows * kLetterScale;
constexpr int kLongestSide = 512;
constexpr int kShortestSide = 48;
constexpr int kGap = 8;
constexpr int kTick = 6;
constexpr int kBarWidth = 24;
constexpr std::array<std::uint8_t, 3> kInk{40, 40, 40};

struct Rectangle {
  int left = 0, top = 0, width = 0, height = 0;
};

std::string shortNumber(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 5).ptr;
  return {text.data(), end};
}

int widthOf(std::string_view text) {
  return static_cast<int>(text.size()) * kLetterWidth - kLetterScale;
}

/// A place on an axis with its label.
struct Tick {
  double place = 0.0;  // 0 at the axis' low end, 1 at its high end
  std::string text;
};

/// Round numbers between two bounds, 1, 2 or 5 times a power of ten apart, at most `most` of them.
std::vector<Tick> ticksOf(double low, double high, int most) {
  const double range = high - low;
  if (!(range > 1e-9 * std::max(std::abs(low), std::abs(high))) || !std::isfinite(range)) {
    return {{0.5, shortNumber(low)}};
  }
  double step = core::pow(10.0, std::floor(core::log10(range / most)));
  for (const double factor : {2.0, 2.5, 2.0}) {
    if (range / step <= most) {
      break;
    }
    step *= factor;
  }
  std::vector<Tick> ticks;
  const double first = std::ceil(low / step - 1e-6);
  for (int k = 0; (first + k) * step <= high + 1e-6 * step; ++k) {
    const double value = (first + k) * step;
    ticks.push_back({std::clamp((value - low) / range, 0.0, 1.0), shortNumber(first + k == 0.0 ? 0.0 : value)});
  }
  return ticks;
}

int widestOf(std::span<const Tick> ticks) {
  int widest = 0;
  for (const Tick& tick : ticks) {
    widest = std::max(widest, widthOf(tick.text));
  }
  return widest;
}

/// An image to write, draw and paint on; pixels outside it are left out.
class Page {
 public:
  Page(int width, int height) : image_{width, height, {}} {
    image_.pixels.assign(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255);
  }

  void pixel(int x, int y, std::span<const std::uint8_t> colour) {
    if (x >= 0 && x < image_.width && y >= 0 && y < image_.height) {
      const std::size_t at =
          4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(x));
      std::copy_n(colour.begin(), 3, image_.pixels.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }

  void fill(const Rectangle& area, std::span<const std::uint8_t> colour) {
    for (int y = area.top; y < area.top + area.height; ++y) {
      for (int x = area.left; x < area.left + area.width; ++x) {
        pixel(x, y, colour);
      }
    }
  }

  /// A line around it, outside.
  void frame(const Rectangle& area) {
    fill({area.left - 1, area.top - 1, area.width + 2, 1}, kInk);
    fill({area.left - 1, area.top + area.height, area.width + 2, 1}, kInk);
    fill({area.left - 1, area.top, 1, area.height}, kInk);
    fill({area.left + area.width, area.top, 1, area.height}, kInk);
  }

  void write(int left, int top, std::string_view text) {
    for (const char letter : text) {
      const auto columns = turtle::letterColumns(letter);
      for (int column = 0; column < 5; ++column) {
        for (int row = 0; row < turtle::kLetterRows; ++row) {
          if ((columns[static_cast<std::size_t>(column)] >> row & 1U) != 0) {
            fill({left + column * kLetterScale, top + row * kLetterScale, kLetterScale, kLetterScale}, kInk);
          }
        }
      }
      left += kLetterWidth;
    }
  }

  /// The colours of a plane, each cell a rectangle.
  void paint(const Rectangle& area, const FieldPlane& plane, std::span<const std::uint8_t> colours) {
    const auto cellAt = [](int place, int length, std::size_t count) {
      return static_cast<std::size_t>(place) * count / static_cast<std::size_t>(length);
    };
    for (int y = 0; y < area.height; ++y) {
      for (int x = 0; x < area.width; ++x) {
        const std::size_t cell =
            cellAt(y, area.height, plane.height) * plane.width + cellAt(x, area.width, plane.width);
        pixel(area.left + x, area.top + y, colours.subspan(4 * cell, 4));
      }
    }
  }

  [[nodiscard]] Image take() { return std::move(image_); }

 private:
  Image image_;
};

/// The sides of a plane in pixels: in proportion, the longer one kLongestSide, a very short one no thinner than can be
/// seen.
std::array<int, 2> sidesOf(double wide, double high) {
  const double scale = kLongestSide / std::max(wide, high);
  const auto side = [&](double length) {
    return std::clamp(static_cast<int>(std::lround(length * scale)), kShortestSide, kLongestSide);
  };
  return {side(wide), side(high)};
}

}  // namespace

Image drawField(const turtle::Field& field, const FieldView& view, const FieldPlane& plane) {
  // the axes of the page, as viewField lays them
  const auto axis = static_cast<std::size_t>(view.axis);
  const std::size_t across = axis == 0 ? 2 : 0;
  const std::size_t upright = axis == 1 ? 2 : 1;
  const bool isDownwards = axis == 1;
  const std::array<double, 3> position{field.position.x, field.position.y, field.position.z};
  const std::array<double, 3> cellSize{field.cellSize.x, field.cellSize.y, field.cellSize.z};
  const auto lengthOf = [&](std::size_t k) { return cellSize[k] * static_cast<double>(field.cells[k]); };
  const std::array<int, 2> sides = sidesOf(lengthOf(across), lengthOf(upright));
  const auto ticksAlong = [&](std::size_t k, int pixels) {
    return ticksOf(position[k], position[k] + lengthOf(k), std::max(pixels / 90, 1));
  };
  const std::vector<Tick> below = ticksAlong(across, sides[0]);
  const std::vector<Tick> beside = ticksAlong(upright, sides[1]);
  const auto [low, high] = rangeOf(plane);
  constexpr int kLeastBar = 160;
  const int barHeight = std::max(sides[1], kLeastBar);
  const std::vector<Tick> ofBar = ticksOf(low, high, barHeight / 40);

  // where everything is
  const std::string axes{"xyz"};
  std::string title = field.name + (field.unit.empty() || field.unit == "1" ? "" : ", " + field.unit);
  const std::string viewText =
      view.at ? std::string(1, axes[axis]) + " = " + shortNumber(*view.at) : "mean along " + axes.substr(axis, 1);
  const int left = kGap + std::max(widestOf(beside), kLetterWidth) + kGap + kTick;
  const int top = 2 * (kGap + kLetterHeight) + 2 * kGap;
  const Rectangle area{left, top, sides[0], sides[1]};
  const Rectangle bar{left + sides[0] + 4 * kGap, top, kBarWidth, barHeight};
  const int right = bar.left + bar.width + kTick + kGap + widestOf(ofBar) + kGap;
  const int width = std::max(right, kGap + std::max(widthOf(title), widthOf(viewText)) + kGap);
  Page page(width, top + std::max(barHeight + kLetterHeight, sides[1] + kTick + 3 * kGap + 2 * kLetterHeight));

  page.write(kGap, kGap, title);
  page.write(kGap, 2 * kGap + kLetterHeight, viewText);
  page.frame(area);
  page.paint(area, plane, colourPlane(plane, low, high));
  // coordinates
  int free = 0;  // numbers do not run into each other
  for (const Tick& tick : below) {
    const int x = area.left + static_cast<int>(tick.place * (area.width - 1));
    page.fill({x, area.top + area.height, 1, kTick}, kInk);
    const int from = std::max(x - widthOf(tick.text) / 2, kGap);
    if (from >= free) {
      page.write(from, area.top + area.height + kTick + kGap / 2, tick.text);
      free = from + widthOf(tick.text) + kLetterWidth;
    }
  }
  const int underNumbers = area.top + area.height + kTick + kGap + kLetterHeight;
  page.write(area.left + (area.width - kLetterWidth) / 2, underNumbers, axes.substr(across, 1));
  for (const Tick& tick : beside) {
    const double part = isDownwards ? tick.place : 1.0 - tick.place;
    const int y = area.top + static_cast<int>(part * (area.height - 1));
    page.fill({area.left - kTick, y, kTick, 1}, kInk);
    page.write(area.left - kTick - kGap / 2 - widthOf(tick.text), y - kLetterHeight / 2, tick.text);
  }
  page.write(kGap, underNumbers, axes.substr(upright, 1));
  // the bar of colours, the greatest number at its top
  FieldPlane scale{1, static_cast<std::size_t>(barHeight), {}};
  for (int row = 0; row < barHeight; ++row) {
    scale.values.push_back(1.0 - static_cast<double>(row) / (barHeight - 1));
  }
  const bool isEven = !(high > low);
  page.frame(bar);
  page.paint(bar, scale, isEven ? colourPlane(scale, 0.5, 0.5) : colourPlane(scale, 0.0, 1.0));
  for (const Tick& tick : ofBar) {
    const int y = bar.top + static_cast<int>((1.0 - tick.place) * (bar.height - 1));
    page.fill({bar.left + bar.width, y, kTick, 1}, kInk);
    page.write(bar.left + bar.width + kTick + kGap / 2, y - kLetterHeight / 2, tick.text);
  }
  return page.take();
}

}  // namespace espalier::environment
