// The pictures of the gallery: made anew they look as they are kept.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "engine/turtle/export/picture/png.h"
#include "tests/clients/program_run.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::test::gallery_pictures_test {
namespace {

namespace fs = std::filesystem;

using turtle::PictureImage;

// CIELAB of an sRGB colour under daylight D65 (CIE 15:2004)
std::array<double, 3> labOf(const std::array<double, 3>& colour) {
  std::array<double, 3> linear{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double c = colour[k] / 255.0;
    linear[k] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }
  const auto f = [](double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; };
  const double x = f((0.4124564 * linear[0] + 0.3575761 * linear[1] + 0.1804375 * linear[2]) / 0.95047);
  const double y = f(0.2126729 * linear[0] + 0.7151522 * linear[1] + 0.0721750 * linear[2]);
  const double z = f((0.0193339 * linear[0] + 0.1191920 * linear[1] + 0.9503041 * linear[2]) / 1.08883);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

// how different two pictures look: squares of 8 by 8 points are compared as the eye sees them from afar, by the
// distance in CIELAB (1 is just noticeable); the mean, and the 99th percentile
struct Difference {
  double mean = 0.0;
  double nearlyLargest = 0.0;
};

Difference differenceOf(const PictureImage& a, const PictureImage& b) {
  constexpr int kSquare = 8;
  std::vector<double> distances;
  const auto meanOf = [](const PictureImage& image, int column, int row) {
    std::array<double, 3> sum{};
    for (int y = 0; y < kSquare; ++y) {
      for (int x = 0; x < kSquare; ++x) {
        const auto at = static_cast<std::size_t>((row * kSquare + y) * image.width + column * kSquare + x) * 4;
        for (std::size_t k = 0; k < 3; ++k) {
          sum[k] += image.pixels[at + k] / static_cast<double>(kSquare * kSquare);
        }
      }
    }
    return sum;
  };
  for (int row = 0; row < a.height / kSquare; ++row) {
    for (int column = 0; column < a.width / kSquare; ++column) {
      const auto p = labOf(meanOf(a, column, row));
      const auto q = labOf(meanOf(b, column, row));
      distances.push_back(std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
    }
  }
  std::sort(distances.begin(), distances.end());
  Difference difference;
  for (const double distance : distances) {
    difference.mean += distance / static_cast<double>(distances.size());
  }
  difference.nearlyLargest = distances[distances.size() * 99 / 100];
  return difference;
}

// `grain`: how much more a grainy picture may differ
bool looksAlike(const PictureImage& a, const PictureImage& b, double grain = 1.0) {
  if (a.width != b.width || a.height != b.height) {
    return false;
  }
  const Difference difference = differenceOf(a, b);
  return difference.mean < 0.5 * grain && difference.nearlyLargest < 6.0 * grain;
}

PictureImage readPicture(const std::string& file) {
  const std::optional<std::string> bytes = readFile(file);
  if (!bytes) {
    ADD_FAILURE() << file << " cannot be read";
    return {};
  }
  auto image = files::readPngImage(*bytes);
  EXPECT_TRUE(image) << file << ": " << image.error();
  return image.value_or(PictureImage{});
}

// each point the mean of four
PictureImage halved(const PictureImage& whole) {
  PictureImage half;
  half.width = whole.width / 2;
  half.height = whole.height / 2;
  half.pixels.resize(static_cast<std::size_t>(half.width * half.height) * 4);
  const auto at = [](const PictureImage& image, int x, int y) {
    return static_cast<std::size_t>(y * image.width + x) * 4;
  };
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      for (std::size_t k = 0; k < 4; ++k) {
        const int sum = whole.pixels[at(whole, 2 * x, 2 * y) + k] + whole.pixels[at(whole, 2 * x + 1, 2 * y) + k] +
                        whole.pixels[at(whole, 2 * x, 2 * y + 1) + k] +
                        whole.pixels[at(whole, 2 * x + 1, 2 * y + 1) + k];
        half.pixels[at(half, x, y) + k] = static_cast<std::uint8_t>((sum + 2) / 4);
      }
    }
  }
  return half;
}

// the further arguments of each picture, by model
std::map<std::string, std::string> pictures() {
  std::map<std::string, std::string> found;
  std::istringstream lines(readFile(sourceFolder() + "/clients/gallery/pictures.txt").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.front() != '#') {
      const std::size_t blank = std::min(line.find(' '), line.size());
      found[line.substr(0, blank)] = line.substr(blank);
    }
  }
  return found;
}

bool isOfChapter(const std::string& model) {
  return model.find('/') != std::string::npos;
}

// a chapter's picture without a file: of `espalier forest`
bool isForest(const std::string& model) {
  return isOfChapter(model) && model.find('.') == std::string::npos;
}

// the picture of a model folder, or of a chapter's file or entry (`chapter-x/file.txt:Entry`); behind `@` a word that
// tells pictures of one model apart
std::string galleryFile(const std::string& model) {
  if (isOfChapter(model)) {
    const std::string file = model.substr(0, model.find_first_of(":@"));
    std::string word = model.substr(file.size());
    std::replace_if(
        word.begin(), word.end(), [](char c) { return c == ':' || c == '@'; }, '-');
    return sourceFolder() + "/clients/gallery/" + file.substr(0, file.rfind('.')) + word + ".png";
  }
  return sourceFolder() + "/clients/gallery/" + model + "/" + model + ".png";
}

class GalleryPicture : public testing::TestWithParam<std::string> {};

TEST_P(GalleryPicture, MadeAnewItLooksAsItIsKept) {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/a.png";
  ASSERT_EQ(setenv("PYTHONPATH", (sourceFolder() + "/clients/python").c_str(), 1), 0);
  const std::string arguments = pictures()[GetParam()];
  // half the size and a few samples tell as much to a person that looks from afar
  const bool isRendered = arguments.find("--render") != std::string::npos;
  const ProgramRun made = runProgram(
      (isForest(GetParam()) ? "forest" : "run clients/gallery/" + GetParam().substr(0, GetParam().find('@'))) +
          arguments + (isRendered ? " --samples 6" : "") + " --size " +
          (isForest(GetParam())      ? "640x480"
           : isOfChapter(GetParam()) ? "320x240"
           : isRendered              ? "400x300"
                                     : "800x600") +
          " --colours 128 --quiet -o " + file,
      sourceFolder());
  ASSERT_EQ(made.status, 0) << made.errors;
  const PictureImage whole = readPicture(galleryFile(GetParam()));
  const PictureImage kept = isRendered && !isOfChapter(GetParam()) ? halved(whole) : whole;
  const PictureImage fresh = readPicture(file);
  ASSERT_EQ(kept.width, fresh.width);
  ASSERT_EQ(kept.height, fresh.height);
  const Difference difference = differenceOf(kept, fresh);
  EXPECT_TRUE(looksAlike(kept, fresh, isRendered ? 2.0 : 1.0))
      << "mean " << difference.mean << ", 99th percentile " << difference.nearlyLargest
      << ". If it is meant to look so, make it with ./dev gallery " << GetParam();
  EXPECT_LE(fs::file_size(galleryFile(GetParam())), isRendered ? 300'000U : 150'000U);
}

std::vector<std::string> models() {
  std::vector<std::string> names;
  for (const auto& [name, arguments] : pictures()) {
    names.push_back(name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Models, GalleryPicture, testing::ValuesIn(models()), [](const auto& parameter) {
  std::string name = parameter.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
});

TEST(GalleryPictures, EveryPictureOfAFolderIsListedAndOnThePage) {
  const std::map<std::string, std::string> listed = pictures();
  const std::string page = readFile(sourceFolder() + "/clients/gallery/README.md").value_or("");
  for (const fs::directory_entry& entry : fs::directory_iterator(sourceFolder() + "/clients/gallery")) {
    const std::string name = entry.path().filename().string();
    if (fs::exists(galleryFile(name))) {
      EXPECT_TRUE(listed.contains(name)) << "pictures.txt does not say how " << name << ".png is made";
      EXPECT_NE(page.find("src=\"" + name + "/" + name + ".png\""), std::string::npos) << name;
    }
  }
}

TEST(GalleryPictures, ADifferenceThatCanBeSeenIsFound) {
  const PictureImage weed = readPicture(galleryFile("classic-weed"));
  EXPECT_TRUE(looksAlike(weed, weed));
  EXPECT_FALSE(looksAlike(weed, readPicture(galleryFile("classic-herb"))));
  // a little darker everywhere, a hole, moved by a few points: each is seen; one level of green in every other point is
  // not
  PictureImage darker = weed;
  PictureImage barely = weed;
  for (std::size_t at = 0; at < weed.pixels.size(); ++at) {
    if (at % 4 != 3) {
      darker.pixels[at] = static_cast<std::uint8_t>(weed.pixels[at] * 97 / 100);
    }
    if (at % 8 == 1 && weed.pixels[at] > 0) {
      --barely.pixels[at];
    }
  }
  EXPECT_FALSE(looksAlike(weed, darker));
  EXPECT_TRUE(looksAlike(weed, barely));
  PictureImage hole = weed;
  for (int y = 250; y < 350; ++y) {
    for (int x = 350; x < 450; ++x) {
      const auto at = static_cast<std::size_t>(y * weed.width + x) * 4;
      std::copy_n(weed.pixels.begin(), 3, hole.pixels.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }
  EXPECT_FALSE(looksAlike(weed, hole));
  PictureImage moved = weed;
  std::rotate(moved.pixels.begin(), moved.pixels.begin() + 4 * 6, moved.pixels.end());
  EXPECT_FALSE(looksAlike(weed, moved));
}

}  // namespace
}  // namespace espalier::test::gallery_pictures_test
