#include "environment/soil/soil_specification.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

#include "environment/published/image_file.h"

namespace espalier::environment {

namespace {

/// The file that the first word of a line names, as an image.
tl::expected<Image, std::string> imageOf(const PublishedLineInput& input, std::vector<std::string>& words) {
  words = readPublishedWords(input.line.value);
  if (words.empty()) {
    return tl::unexpected(std::string("names no image file"));
  }
  const std::string name = besideFile(input.file, words[0]);
  const auto content = input.files.read(name);
  if (!content) {
    return tl::unexpected("names the file '" + name +
                          "', which cannot be read; it is looked for beside the specification");
  }
  auto image = decodeImage(*content);
  if (const auto* problem = std::get_if<std::string>(&image)) {
    return tl::unexpected("names the file '" + name + "', which " + *problem);
  }
  return std::get<Image>(std::move(image));
}

}  // namespace

std::string readArray(const PublishedLineInput& input) {
  const std::vector<double> head = readPublishedNumbers(input.line.value);
  if (head.size() < 5) {
    return "needs 5 numbers, columns, rows, slices, smallest and largest value, found " + std::to_string(head.size());
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(head[i] >= 1.0 && head[i] <= 4096.0) || head[i] != std::floor(head[i])) {
      return "needs whole numbers of columns, rows and slices, 1 to 4096";
    }
  }
  const auto columns = static_cast<std::size_t>(head[0]);
  const auto rowCount = static_cast<std::size_t>(head[1]) * static_cast<std::size_t>(head[2]);
  std::vector<double> numbers(head.begin() + 5, head.end());
  for (const std::string& data : input.line.data) {
    const auto more = readPublishedNumbers(data);
    numbers.insert(numbers.end(), more.begin(), more.end());
  }
  if (numbers.size() < columns * rowCount) {
    return "needs " + std::to_string(columns * rowCount) + " concentrations on the lines below, found " +
           std::to_string(numbers.size());
  }
  ConfigurationRows rows;
  for (std::size_t row = 0; row < rowCount; ++row) {
    const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(row * columns);
    rows.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(columns));
  }
  input.values.insert_or_assign("concentration", std::move(rows));
  input.values.insert_or_assign("sliceCount", head[2]);
  input.values.insert_or_assign("concentrationRange", std::vector<double>{head[3], head[4]});
  return {};
}

std::string readConcentrationImage(const PublishedLineInput& input) {
  std::vector<std::string> words;
  const auto read = imageOf(input, words);
  if (!read) {
    return read.error();
  }
  std::vector<double> range{0.0, 1.0};
  if (words.size() > 1) {
    range = readPublishedNumbers(input.line.value.substr(words[0].size()));
    if (range.size() != 2) {
      return "needs the smallest and the largest value after the file's name, or neither";
    }
  }
  const auto& image = *read;
  ConfigurationRows rows;
  for (std::size_t y = image.height; y-- > 0;) {
    rows.emplace_back();
    for (std::size_t x = 0; x < image.width; ++x) {
      rows.back().push_back(range[0] + (range[1] - range[0]) * image.at(x, y, 1) / 255.0);
    }
  }
  input.values.insert_or_assign("concentration", std::move(rows));
  input.values.insert_or_assign("sliceCount", 1.0);
  input.values.insert_or_assign("concentrationRange", std::move(range));
  return {};
}

std::string readObstacleImage(const PublishedLineInput& input) {
  std::vector<std::string> words;
  const auto read = imageOf(input, words);
  if (!read) {
    return read.error();
  }
  const auto& image = *read;
  ConfigurationRows obstacles;
  ConfigurationRows sources;
  for (std::size_t y = image.height; y-- > 0;) {
    obstacles.emplace_back();
    sources.emplace_back();
    for (std::size_t x = 0; x < image.width; ++x) {
      obstacles.back().push_back(image.at(x, y, 0) >= 128 ? 1.0 : 0.0);
      sources.back().push_back(image.at(x, y, 1) >= 128 ? 1.0 : 0.0);
    }
  }
  input.values.insert_or_assign("obstacleMap", std::move(obstacles));
  input.values.insert_or_assign("sourceMap", std::move(sources));
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
  const auto numbers = readPublishedNumbers(input.line.value);
  if (numbers.empty()) {
    return "needs a number of steps, found '" + input.line.value + "'";
  }
  input.values.insert_or_assign("diffusionSteps", std::trunc(numbers[0]));
  if (numbers.size() > 1) {
    input.values.insert_or_assign("diffusionTolerance", numbers[1]);
  }
  return {};
}

std::string readThicknesses(const PublishedLineInput& input) {
  input.values.insert_or_assign("layerThicknesses", readPublishedNumbers(input.line.value));
  return {};
}

std::string readAngles(const PublishedLineInput& input) {
  input.values.insert_or_assign("geotropicAngles", readPublishedNumbers(input.line.value));
  return {};
}

}  // namespace espalier::environment
