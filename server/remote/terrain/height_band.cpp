#include "server/remote/terrain/height_band.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

namespace espalier::server {

namespace {

constexpr double kMostHeight = 1e100;
constexpr std::size_t kMostUnit = 40;  // characters

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// The number at the beginning of a text, which may have blanks or a plus in front.
std::optional<double> numberOf(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) {
    text.remove_prefix(1);
  }
  double value = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range) {
    // too small, or too large
    const std::string_view digits(text.data(), rest);
    const bool isSmall = digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos;
    const double size = isSmall ? 0.0 : std::numeric_limits<double>::infinity();
    return digits.starts_with('-') ? -size : size;
  }
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

/// The content of an item of GDAL's metadata; nothing when there is none with this role.
std::optional<std::string_view> itemOf(std::string_view items, const std::string& role) {
  const std::size_t at = items.find("role=\"" + role + "\"");
  const std::size_t begin = at == std::string_view::npos ? at : items.find('>', at);
  if (begin == std::string_view::npos) {
    return std::nullopt;
  }
  const std::string_view rest = items.substr(begin + 1);
  return trimmed(rest.substr(0, rest.find('<')));
}

bool isMetre(std::string_view unit) {
  std::string lower(unit);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 5> kNames = {"m", "metre", "meter", "metres", "meters"};
  return std::ranges::find(kNames, lower) != kNames.end();
}

/// A name of the file as a message can have it: of visible characters, and short.
std::string shown(std::string_view name) {
  std::string text(name.substr(0, kMostUnit));
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
  return text;
}

bool isHeight(double number) {
  return std::abs(number) < kMostHeight;
}

}  // namespace

double HeightBand::numberAt(const char* row, std::size_t index) const {
  const auto as = [&](auto value) {
    std::memcpy(&value, row + index * sizeof(value), sizeof(value));
    return static_cast<double>(value);
  };
  if (bits == 1) {
    return (static_cast<unsigned char>(row[index / 8]) >> (7 - index % 8)) & 1;
  }
  if (isReal) {
    return bits == 64 ? as(double{}) : as(float{});
  }
  if (isSigned) {
    return bits == 8 ? as(std::int8_t{}) : bits == 16 ? as(std::int16_t{}) : as(std::int32_t{});
  }
  return bits == 8 ? as(std::uint8_t{}) : bits == 16 ? as(std::uint16_t{}) : as(std::uint32_t{});
}

void HeightBand::takeNoData(std::string_view text) {
  noData = numberOf(text);
  if (noData && isReal && bits == 32) {
    constexpr double kMost = std::numeric_limits<float>::max();
    noData = static_cast<float>(std::clamp(*noData, -kMost, kMost));
  }
}

std::optional<std::string> HeightBand::takeMetadata(std::string_view items) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (const auto text = itemOf(items, "scale")) {
    scale = numberOf(*text).value_or(kNone);
  }
  if (const auto text = itemOf(items, "offset")) {
    offset = numberOf(*text).value_or(kNone);
  }
  const auto unit = itemOf(items, "unittype");
  if (!unit || unit->empty() || isMetre(*unit)) {
    return std::nullopt;
  }
  return "has heights in '" + shown(*unit) +
         "', not in metres. If gdalwarp has converted them already, say so with gdal_edit.py -units m. Else convert "
         "them, as with gdal_calc.py --calc=A*0.3048 for feet";
}

std::optional<std::string> HeightBand::finish(std::vector<double>& heights) const {
  const auto missing =
      std::ranges::count_if(heights, [&](double height) { return !isHeight(height) || (noData && height == *noData); });
  if (missing > 0) {
    return "has " + std::to_string(missing) + " of " + std::to_string(heights.size()) +
           " cells without a height. Fill them, as with gdal_fillnodata.py, or cut out a part";
  }
  for (double& height : heights) {
    height = height * scale + offset;
  }
  if (!std::ranges::all_of(heights, isHeight)) {
    return "has a scale or an offset that is no finite number. Get an undamaged copy";
  }
  return std::nullopt;
}

}  // namespace espalier::server
