#include "environment/soil/soil_specification.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "environment/base/image_of_line.h"

namespace espalier::environment {

namespace {

/// The separators between thicknesses, which may be written as a sum.
constexpr std::string_view kSumSeparators = "+,;: \t\r";

/// Whether `obstacles and sources: on` stands above the line.
bool hasKindsBefore(const PublishedLineInput& input) {
  bool hasKinds = false;
  for (const PublishedLine& line : input.before) {
    if (line.keyword == "obstacles and sources") {
      hasKinds = firstPublishedWord(line.value) == "on";
    }
  }
  return hasKinds;
}

/// The three maps of a field, as rows.
struct SoilMaps {
  ConfigurationRows concentrations;
  ConfigurationRows obstacles;
  ConfigurationRows sources;
  bool hasKinds = false;

  void addRow() {
    concentrations.emplace_back();
    obstacles.emplace_back();
    sources.emplace_back();
  }
  void add(double concentration, bool isObstacle, bool isSource) {
    concentrations.back().push_back(concentration);
    obstacles.back().push_back(isObstacle ? 1.0 : 0.0);
    sources.back().push_back(isSource ? 1.0 : 0.0);
  }
};

void setMaps(const PublishedLineInput& input, SoilMaps maps, double sliceCount, double least, double most) {
  input.values.insert_or_assign("concentration", std::move(maps.concentrations));
  input.values.insert_or_assign("sliceCount", sliceCount);
  input.values.insert_or_assign("concentrationRange", std::vector<double>{least, most});
  if (maps.hasKinds) {
    input.values.insert_or_assign("obstacleMap", std::move(maps.obstacles));
    input.values.insert_or_assign("sourceMap", std::move(maps.sources));
  }
}

}  // namespace

std::string readArray(const PublishedLineInput& input) {
  bool areWhole = true;
  std::vector<double> head = readPublishedNumbers(input.line.value, &areWhole);
  // columns, rows, slices, smallest and largest value
  constexpr std::array kDefaults{1.0, 1.0, 1.0, 0.0, 1.0};
  for (std::size_t i = head.size(); i < kDefaults.size(); ++i) {
    head.push_back(kDefaults[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    head[i] = std::trunc(head[i]);
    if (!(head[i] >= 1.0 && head[i] <= 4096.0)) {
      return "needs 1 to 4096 columns, rows and slices";
    }
  }
  const auto columns = static_cast<std::size_t>(head[0]);
  const auto rowCount = static_cast<std::size_t>(head[1]) * static_cast<std::size_t>(head[2]);
  std::vector<double> numbers(head.begin() + 5, head.end());
  for (const std::string& data : input.line.data) {
    const auto more = readPublishedNumbers(data, &areWhole);
    numbers.insert(numbers.end(), more.begin(), more.end());
  }
  if (numbers.size() < columns * rowCount) {
    return "needs " + std::to_string(columns * rowCount) + " concentrations on the lines below, found " +
           std::to_string(numbers.size());
  }
  if (!areWhole || numbers.size() > columns * rowCount) {
    input.dropped = "is followed by text that is no number, or by too many numbers: they are ignored";
  }
  SoilMaps maps;
  maps.hasKinds = hasKindsBefore(input);
  for (std::size_t i = 0; i < columns * rowCount; ++i) {
    if (i % columns == 0) {
      maps.addRow();
    }
    maps.add(numbers[i], numbers[i] <= head[3], numbers[i] >= head[4]);
  }
  setMaps(input, std::move(maps), head[2], head[3], head[4]);
  return {};
}

std::string readSoilImage(const PublishedLineInput& input) {
  const std::vector<std::string> words = readPublishedWords(input.line.value);
  if (words.size() < 3) {
    return "needs the smallest and the largest value and a file, found '" + input.line.value + "'";
  }
  if (words.size() > 3) {
    input.dropped = "names one file: the text after it is ignored";
  }
  const double least = readPublishedNumbers(words[0]).at(0);
  const double most = readPublishedNumbers(words[1]).at(0);
  const auto image = readImageBeside(input, words[2]);
  if (!image) {
    return image.error();
  }
  SoilMaps maps;
  maps.hasKinds = hasKindsBefore(input);
  for (int y = 0; y < image->height; ++y) {
    maps.addRow();
    for (int x = 0; x < image->width; ++x) {
      const int red = image->at(x, y, 0);
      const int green = image->at(x, y, 1);
      const int blue = image->at(x, y, 2);
      const bool isSource = red == 255 && green == 255 && blue == 255;
      const bool isObstacle = !isSource && ((red == 40 && green == 55 && blue == 70) || (red == blue && red > 0));
      const double part = maps.hasKinds ? green / 255.0 : (0.299 * red + 0.587 * green + 0.114 * blue) / 255.0;
      maps.add(least + (most - least) * part, isObstacle, isSource);
    }
  }
  setMaps(input, std::move(maps), 1.0, least, most);
  return {};
}

std::string readPrimitives(const PublishedLineInput& input) {
  const std::string name = besideFile(input.file, input.line.value);
  auto text = input.files.read(name);
  if (!text) {
    return "names the file '" + name + "', which cannot be read; it is looked for beside the specification";
  }
  input.values.insert_or_assign("obstacleScene", std::move(*text));
  return {};
}

std::string readDiffusion(const PublishedLineInput& input) {
  bool areWhole = true;
  const auto numbers = readPublishedNumbers(input.line.value, &areWhole);
  if (numbers.empty()) {
    input.dropped = "has no number of sweeps: there is no diffusion";
    return {};
  }
  const double sweeps = std::trunc(numbers[0]);
  if (!areWhole || numbers.size() > 2) {
    input.dropped = "is read as " + std::to_string(static_cast<long>(sweeps)) + " sweeps: the rest is ignored";
  }
  // a number of sweeps is exact, whatever tolerance follows
  input.values.insert_or_assign("diffusionSteps", sweeps);
  if (sweeps < 0.0) {
    input.values.insert_or_assign("diffusionTolerance", numbers.size() > 1 ? numbers[1] : 0.0);
  }
  return {};
}

std::string readThicknesses(const PublishedLineInput& input) {
  input.values.insert_or_assign("layerThicknesses", readPublishedNumbers(input.line.value, nullptr, kSumSeparators));
  return {};
}

std::string readAngles(const PublishedLineInput& input) {
  // without thicknesses there is the one layer of the defaults
  std::size_t layerCount = 1;
  for (const PublishedLine& line : input.all) {
    if (line.keyword == "layer thicknesses") {
      layerCount = readPublishedNumbers(line.value, nullptr, kSumSeparators).size();
    }
  }
  std::vector<double> angles = readPublishedNumbers(input.line.value);
  if (angles.size() > layerCount) {
    input.dropped = "has " + std::to_string(angles.size()) + " angles for " + std::to_string(layerCount) +
                    " layers: the others are ignored";
    angles.resize(layerCount);
  }
  input.values.insert_or_assign("geotropicAngles", std::move(angles));
  return {};
}

}  // namespace espalier::environment
