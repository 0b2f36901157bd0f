#include "clients/espalier/output/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "clients/espalier/messages.h"
#include "engine/turtle/export/picture/bitmap_font.h"
#include "engine/turtle/export/picture/png.h"

namespace espalier::command {
namespace {

constexpr int kCellWidth = 320;
constexpr int kCellHeight = 240;
constexpr int kTitleHeight = 18;
constexpr int kGap = 4;
constexpr int kLetterWidth = 6;  // five columns and a gap
constexpr std::uint8_t kPaper = 255;
constexpr std::uint8_t kInk = 40;

void setPoint(turtle::PictureImage& image, int x, int row, const std::uint8_t* colour) {
  if (x < 0 || row < 0 || x >= image.width || row >= image.height) {
    return;
  }
  const auto index =
      (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)) * 4;
  std::copy_n(colour, 4, image.pixels.begin() + static_cast<std::ptrdiff_t>(index));
}

void drawText(turtle::PictureImage& image, int x, int row, std::string_view text, int room) {
  constexpr std::uint8_t kColour[4] = {kInk, kInk, kInk, 255};
  const auto most = static_cast<std::size_t>(std::max(0, room / kLetterWidth));
  for (const char letter : text.substr(0, most)) {
    const auto columns = turtle::letterColumns(letter);
    for (int column = 0; column < 5; ++column) {
      for (int bit = 0; bit < turtle::kLetterRows; ++bit) {
        if ((columns[static_cast<std::size_t>(column)] >> bit & 1) != 0) {
          setPoint(image, x + column, row + bit, kColour);
        }
      }
    }
    x += kLetterWidth;
  }
}

// a cell's picture over white paper
void drawImage(turtle::PictureImage& sheet, const turtle::PictureImage& image, int left, int top) {
  for (int row = 0; row < image.height; ++row) {
    for (int x = 0; x < image.width; ++x) {
      const int opacity = image.at(x, row, 3);
      std::uint8_t colour[4] = {0, 0, 0, 255};
      for (int channel = 0; channel < 3; ++channel) {
        colour[channel] =
            static_cast<std::uint8_t>((image.at(x, row, channel) * opacity + kPaper * (255 - opacity)) / 255);
      }
      setPoint(sheet, left + x, top + row, colour);
    }
  }
}

}  // namespace

bool ContactSheet::add(const simulation::Simulation& simulation, const std::string& name) {
  const auto scene = simulation.scene();
  if (!scene) {
    printError(formatSimulationError(scene.error()));
    return false;
  }
  turtle::PictureOptions picture = options_.picture;
  picture.palette = &simulation.options().palette;
  cells_.push_back({turtle::renderPicture(*scene, simulation.view(), picture), name});
  return true;
}

void ContactSheet::addFailed(const std::string& name) {
  cells_.push_back({{}, name + " (error)"});
}

turtle::PictureImage ContactSheet::assembled() const {
  const int width = options_.picture.widthPixels + kGap;
  const int height = options_.picture.heightPixels + kTitleHeight + kGap;
  const auto count = static_cast<int>(cells_.size());
  // about as wide as high, within the largest picture
  int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count) * height / width))));
  columns = std::min(columns, turtle::kMaximumPicturePixels / width);
  const int rows = std::min((count + columns - 1) / columns, turtle::kMaximumPicturePixels / height);
  turtle::PictureImage sheet;
  sheet.width = columns * width + kGap;
  sheet.height = rows * height + kGap;
  sheet.pixels.assign(static_cast<std::size_t>(sheet.width) * static_cast<std::size_t>(sheet.height) * 4, kPaper);
  for (int i = 0; i < std::min(count, columns * rows); ++i) {
    const Cell& cell = cells_[static_cast<std::size_t>(i)];
    const int left = kGap + i % columns * width;
    const int top = kGap + i / columns * height;
    drawImage(sheet, cell.image, left, top);
    drawText(sheet, left + kGap, top + options_.picture.heightPixels + kGap, cell.name, options_.picture.widthPixels);
  }
  return sheet;
}

bool ContactSheet::write(bool isQuiet) const {
  const turtle::PictureImage sheet = assembled();
  return std::ranges::all_of(options_.files, [&](const std::string& file) {
    return writePicture(options_, sheet, file, std::to_string(cells_.size()) + " models", isQuiet);
  });
}

int checkSheetOutputs(const OutputOptions& options) {
  for (const std::string& file : options.files) {
    const turtle::ExportFormat* const format = formatOf(options, file);
    if (format == nullptr || format->name != "png") {
      printError("'" + file + "' cannot hold a contact sheet of all models: give a .png");
      return kUsage;
    }
  }
  return checkOutputs(options);
}

void setCellSize(OutputOptions& options) {
  const turtle::PictureOptions defaults;
  if (options.picture.widthPixels == defaults.widthPixels && options.picture.heightPixels == defaults.heightPixels) {
    options.picture.widthPixels = kCellWidth;
    options.picture.heightPixels = kCellHeight;
  }
}

}  // namespace espalier::command
