#include "clients/espalier/output/growth_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string_view>

#include "engine/core/elementary.h"

namespace espalier::command {
namespace {

// pixels
constexpr double kWidth = 640.0;
constexpr double kHeight = 420.0;
constexpr double kLeft = 60.0;
constexpr double kRight = 450.0;  // names stand beyond
constexpr double kTop = 20.0;
constexpr double kBottom = 380.0;

constexpr std::array<std::string_view, 8> kColours{"#3b6fb6", "#c8553d", "#4f8f3a", "#8a5aa8",
                                                   "#c79a1e", "#3a9a98", "#7a5c3e", "#b0447a"};

std::string number(double value) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.1f", value);
  return {text.data(), static_cast<std::size_t>(length)};
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return result;
}

std::string line(double x1, double y1, double x2, double y2, std::string_view colour) {
  return "<path fill=\"none\" stroke=\"" + std::string(colour) + "\" d=\"M" + number(x1) + " " + number(y1) + "L" +
         number(x2) + " " + number(y2) + "\"/>\n";
}

std::string label(double x, double y, std::string_view anchor, std::string_view text) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + std::string(anchor) + "\">" +
         escaped(text) + "</text>\n";
}

// 1, 10, 100, 1000, and powers beyond
std::string powerOfTen(int exponent) {
  constexpr std::array<std::string_view, 10> kRaised{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  if (exponent < 4) {
    return "1" + std::string(static_cast<std::size_t>(exponent), '0');
  }
  std::string text = "10";
  for (const char digit : std::to_string(exponent)) {
    text += kRaised[static_cast<std::size_t>(digit - '0')];
  }
  return text;
}

}  // namespace

std::string growthPlot(const std::vector<GrowthCurve>& curves) {
  std::size_t steps = 1;
  std::uint64_t longest = 10;
  for (const GrowthCurve& curve : curves) {
    steps = std::max(steps, curve.lengths.empty() ? 0 : curve.lengths.size() - 1);
    for (const std::uint64_t length : curve.lengths) {
      longest = std::max(longest, length);
    }
  }
  const int decades = static_cast<int>(std::ceil(core::log10(static_cast<double>(longest))));
  const auto xOf = [&](std::size_t step) {
    return kLeft + (kRight - kLeft) * static_cast<double>(step) / static_cast<double>(steps);
  };
  const auto yOf = [&](double length) {
    return kBottom - (kBottom - kTop) * core::log10(std::max(1.0, length)) / decades;
  };

  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(kWidth) + "\" height=\"" +
                    number(kHeight) + "\" viewBox=\"0 0 " + number(kWidth) + " " + number(kHeight) +
                    "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
                    "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  // axes
  for (int decade = 0; decade <= decades; ++decade) {
    const double y = yOf(core::pow(10.0, decade));
    svg += line(kLeft, y, kRight, y, "#dddddd");
    svg += label(kLeft - 6.0, y + 4.0, "end", powerOfTen(decade));
  }
  const std::size_t stride = std::max<std::size_t>(1, steps / 10);
  for (std::size_t step = 0; step <= steps; step += stride) {
    svg += label(xOf(step), kBottom + 18.0, "middle", std::to_string(step));
  }
  svg += label((kLeft + kRight) / 2.0, kHeight - 6.0, "middle", "generation");
  // curves with their names
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const std::string_view colour = kColours[i % kColours.size()];
    std::string path;
    for (std::size_t step = 0; step < curves[i].lengths.size(); ++step) {
      path +=
          (step == 0 ? "M" : "L") + number(xOf(step)) + " " + number(yOf(static_cast<double>(curves[i].lengths[step])));
    }
    // over one just like it: dashed, so that both are seen
    const auto end = curves.begin() + static_cast<std::ptrdiff_t>(i);
    const bool isAgain = std::any_of(curves.begin(), end,
                                     [&](const GrowthCurve& before) { return before.lengths == curves[i].lengths; });
    svg += "<path fill=\"none\" stroke=\"" + std::string(colour) + "\" stroke-width=\"2\"" +
           (isAgain ? " stroke-dasharray=\"7 7\"" : "") + " d=\"" + path + "\"/>\n";
    const double y = kTop + 18.0 * static_cast<double>(i + 1);
    svg += line(kRight + 16.0, y - 4.0, kRight + 36.0, y - 4.0, colour);
    svg += label(kRight + 42.0, y, "start", curves[i].name);
  }
  return svg + "</svg>\n";
}

}  // namespace espalier::command
