#include "engine/turtle/export/exporters.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "engine/turtle/export/glb.h"
#include "engine/turtle/export/module_table.h"
#include "engine/turtle/export/mtg.h"
#include "engine/turtle/export/obj.h"
#include "engine/turtle/export/picture.h"
#include "engine/turtle/export/ply.h"
#include "engine/turtle/export/png.h"
#include "engine/turtle/export/postscript.h"
#include "engine/turtle/export/stl.h"
#include "engine/turtle/export/svg.h"
#include "engine/turtle/export/usda.h"

namespace espalier::turtle {

namespace {

std::optional<std::string> exportSvg(const ExportInput& input, const ExportTarget& target) {
  SvgOptions options{.palette = input.palette};
  if (input.picture != nullptr) {
    options.widthPixels = input.picture->widthPixels;
    options.heightPixels = input.picture->heightPixels;
    options.hasBackground = input.picture->background == PictureBackground::Model;
  }
  writeSvg(input.scene, input.view, options, target.sink);
  return std::nullopt;
}

std::optional<std::string> exportPostScript(const ExportInput& input, const ExportTarget& target) {
  writePostScript(input.scene, input.view, {.palette = input.palette}, target.sink);
  return std::nullopt;
}

std::optional<std::string> exportPng(const ExportInput& input, const ExportTarget& target) {
  PictureOptions options = input.picture != nullptr ? *input.picture : PictureOptions{};
  options.palette = input.palette;
  return writePng(renderPicture(input.scene, input.view, options), target.sink, options.maximumColours);
}

constexpr std::array kFormats = {
    ExportFormat{"png", ".png", "a shaded picture of points", exportPng},
    ExportFormat{"svg", ".svg", "a drawing of lines and areas for web pages", exportSvg},
    ExportFormat{"eps", ".eps", "a drawing of lines and areas for print (PostScript)", exportPostScript},
    ExportFormat{"ps", ".ps", "the same with another suffix", exportPostScript},
    ExportFormat{"glb", ".glb", "meshes, materials and repeated organs (binary glTF 2.0)", exportGlb},
    ExportFormat{"obj", ".obj", "triangles and quads for 3-D programs, with a .mtl of colours", exportObj},
    ExportFormat{"ply", ".ply", "a mesh whose vertices know plant, module and order (binary)", exportPly},
    ExportFormat{"stl", ".stl", "triangles only, for printing (binary)", exportStl},
    ExportFormat{"usda", ".usda", "a USD stage in text; also of a growing plant", exportUsda, beginUsdaGrowth},
    ExportFormat{"mtg", ".mtg", "a multiscale tree graph with geometry, for plant science", writeMtg, nullptr,
                 ExportSource::Modules},
    ExportFormat{"csv", ".csv", "a table of all modules with the turtle's state", writeModuleTable, nullptr,
                 ExportSource::Modules},
    ExportFormat{"string", ".string", "the derived string as text, to start from with --from", writeStrings, nullptr,
                 ExportSource::Modules},
};

char lowerCase(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

}  // namespace

std::span<const ExportFormat> exportFormats() {
  return kFormats;
}

const ExportFormat* findExportFormat(std::string_view name) {
  const auto* const found = std::ranges::find(kFormats, name, &ExportFormat::name);
  return found == kFormats.end() ? nullptr : found;
}

const ExportFormat* findExportFormatOfFile(std::string_view fileName) {
  const auto* const found = std::ranges::find_if(kFormats, [fileName](const ExportFormat& format) {
    return fileName.size() >= format.suffix.size() &&
           std::ranges::equal(fileName.substr(fileName.size() - format.suffix.size()), format.suffix, {}, lowerCase);
  });
  return found == kFormats.end() ? nullptr : found;
}

std::string withSuffix(std::string_view fileName, std::string_view suffix) {
  const std::size_t point = fileName.rfind('.');
  // a leading point begins a hidden file's name
  const bool hasSuffix = point != std::string_view::npos && point > 0;
  return std::string(hasSuffix ? fileName.substr(0, point) : fileName) + std::string(suffix);
}

}  // namespace espalier::turtle
