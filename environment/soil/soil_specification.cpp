#include "environment/soil/soil_specification.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "environment/base/image_of_line.h"

namespace espalier::environment {

namespace {

/// The file that the first word of a line names, as an image.
tl::expected<files::Image, std::string> imageOf(const PublishedLineInput& input,
                                                const std::vector<std::string>& words) {
  if (words.empty()) {
    return tl::unexpected(std::string("names no image file"));
  }
  return readImageBeside(input, words[0]);
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
  const std::vector<std::string> words = readPublishedWords(input.line.value);
  const auto image = imageOf(input, words);
  if (!image) {
    return image.error();
  }
  std::vector<double> range{0.0, 1.0};
  if (words.size() > 1) {
    range = readPublishedNumbers(input.line.value.substr(words[0].size()));
    if (range.size() != 2) {
      return "needs the smallest and the largest value after the file's name, or neither";
    }
  }
  ConfigurationRows rows;
  for (int y = 0; y < image->height; ++y) {
    rows.emplace_back();
    for (int x = 0; x < image->width; ++x) {
      rows.back().push_back(range[0] + (range[1] - range[0]) * image->at(x, y, 1) / 255.0);
    }
  }
  input.values.insert_or_assign("concentration", std::move(rows));
  input.values.insert_or_assign("sliceCount", 1.0);
  input.values.insert_or_assign("concentrationRange", std::move(range));
  return {};
}

std::string readObstacleImage(const PublishedLineInput& input) {
  const std::vector<std::string> words = readPublishedWords(input.line.value);
  const auto image = imageOf(input, words);
  if (!image) {
    return image.error();
  }
  ConfigurationRows obstacles;
  ConfigurationRows sources;
  for (int y = 0; y < image->height; ++y) {
    obstacles.emplace_back();
    sources.emplace_back();
    for (int x = 0; x < image->width; ++x) {
      obstacles.back().push_back(image->at(x, y, 0) >= 128 ? 1.0 : 0.0);
      sources.back().push_back(image->at(x, y, 1) >= 128 ? 1.0 : 0.0);
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
