#include "clients/espalier/validation/result_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string_view>

#include "engine/core/elementary.h"

namespace espalier::validation {

namespace {

// pixels
constexpr double kPictureWidth = 760.0;
constexpr double kPictureHeight = 440.0;
constexpr double kLeft = 70.0;
constexpr double kRight = 520.0;  // names stand beyond
constexpr double kTop = 40.0;
constexpr double kBottom = 410.0;
constexpr std::array<std::string_view, 9> kColours{"#3b6fb6", "#c8553d", "#4f8f3a", "#8a5aa8", "#c79a1e",
                                                   "#3a9a98", "#7a5c3e", "#b0447a", "#555555"};

std::string number(double value, const char* format = "%.1f") {
  std::array<char, 40> text{};
  const int length = std::snprintf(text.data(), text.size(), format, value);
  return {text.data(), static_cast<std::size_t>(length)};
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char letter : text) {
    safe += letter == '&' ? "&amp;" : letter == '<' ? "&lt;" : std::string(1, letter);
  }
  return safe;
}

std::string label(double x, double y, std::string_view anchor, std::string_view text) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + std::string(anchor) + "\">" +
         escaped(text) + "</text>\n";
}

/// A line through places. References are dashed.
std::string path(const std::string& places, std::string_view colour, bool isDashed) {
  return "<path fill=\"none\" stroke=\"" + std::string(colour) + "\" stroke-width=\"2\"" +
         (isDashed ? " stroke-dasharray=\"3 5\"" : "") + " d=\"" + places + "\"/>\n";
}

/// Dots at places, as lines of no length with round ends. References are large and pale: results lie on them.
std::string dots(const std::string& places, std::string_view colour, bool isPale) {
  return "<path fill=\"none\" stroke-linecap=\"round\" stroke=\"" + std::string(colour) + "\" stroke-width=\"" +
         (isPale ? "7\" opacity=\"0.3\"" : "3\"") + " d=\"" + places + "\"/>\n";
}

/// A range of numbers and the distance of its marks: 1, 2 or 5 times a power of ten.
struct Axis {
  double low = 0.0;
  double high = 1.0;
  double mark = 0.2;
};

Axis axisOf(const std::vector<Curve>& curves, bool isVertical) {
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  for (const Curve& curve : curves) {
    for (const auto& [x, y] : curve.points) {
      low = std::min(low, isVertical ? y : x);
      high = std::max(high, isVertical ? y : x);
    }
  }
  if (!(high > low)) {
    high = low + 1.0;
  }
  double mark = core::pow(10.0, std::floor(core::log10(high - low)));
  for (const double factor : {0.5, 0.4, 0.5}) {
    mark = (high - low) / mark < 5.0 ? mark * factor : mark;
  }
  return {low, high, mark};
}

}  // namespace

std::string resultPlot(const std::string& title, const Picture& picture) {
  const std::vector<Curve>& curves = picture.curves;
  if (curves.empty()) {
    return {};
  }
  const Axis across = axisOf(curves, false);
  const Axis up = axisOf(curves, true);
  const auto xOf = [&](double x) { return kLeft + (kRight - kLeft) * (x - across.low) / (across.high - across.low); };
  const auto yOf = [&](double y) { return kBottom - (kBottom - kTop) * (y - up.low) / (up.high - up.low); };
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(kPictureWidth) + "\" height=\"" +
                    number(kPictureHeight) + "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
                    "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n" + label(kLeft, 16.0, "start", title) +
                    label(kLeft, 33.0, "start", picture.up) + label(kRight, kBottom + 28.0, "end", picture.across);
  for (double x = std::ceil(across.low / across.mark) * across.mark; x <= across.high; x += across.mark) {
    svg += label(xOf(x), kBottom + 14.0, "middle", number(std::abs(x) < 1e-9 * across.mark ? 0.0 : x, "%.6g"));
  }
  for (double y = std::ceil(up.low / up.mark) * up.mark; y <= up.high; y += up.mark) {
    svg += "<path stroke=\"#dddddd\" d=\"M" + number(kLeft) + " " + number(yOf(y)) + "H" + number(kRight) + "\"/>\n";
    svg += label(kLeft - 6.0, yOf(y) + 4.0, "end", number(std::abs(y) < 1e-9 * up.mark ? 0.0 : y, "%.6g"));
  }
  // a result and its reference have one colour: "loam" and "loam, converged"
  std::map<std::string, std::string_view> colours;
  double height = kTop;
  for (const Curve& curve : curves) {
    // of a published table that is not here
    if (curve.points.empty()) {
      continue;
    }
    const std::string subject = curve.name.substr(0, curve.name.find(", "));
    const auto [colour, isNew] = colours.try_emplace(subject, kColours[colours.size() % kColours.size()]);
    std::string places;
    for (const auto& [x, y] : curve.points) {
      places += (places.empty() || curve.isDots ? "M" : "L") + number(xOf(x)) + " " + number(yOf(y)) +
                (curve.isDots ? "h0" : "");
    }
    height += 16.0;
    const std::string sample = "M" + number(kRight + (curve.isDots ? 24.0 : 12.0)) + " " + number(height - 4.0);
    svg += curve.isDots ? dots(places + sample + "h0", colour->second, curve.isReference)
                        : path(places, colour->second, curve.isReference) +
                              path(sample + "H" + number(kRight + 36.0), colour->second, curve.isReference);
    svg += label(kRight + 42.0, height, "start", curve.name);
  }
  return svg + "</svg>\n";
}

}  // namespace espalier::validation
