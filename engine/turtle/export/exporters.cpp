#include "engine/turtle/export/exporters.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "engine/turtle/export/background_drawing.h"
#include "engine/turtle/export/mesh/glb.h"
#include "engine/turtle/export/mesh/obj.h"
#include "engine/turtle/export/mesh/ply.h"
#include "engine/turtle/export/mesh/stl.h"
#include "engine/turtle/export/mesh/usda.h"
#include "engine/turtle/export/mesh/vtp.h"
#include "engine/turtle/export/picture/picture.h"
#include "engine/turtle/export/picture/png.h"
#include "engine/turtle/export/picture/postscript.h"
#include "engine/turtle/export/picture/svg.h"
#include "engine/turtle/export/text/module_table.h"
#include "engine/turtle/export/text/mtg.h"
#include "engine/turtle/export/text/rsml.h"

namespace espalier::turtle {

namespace {

std::optional<std::string> exportSvg(const ExportInput& input, const ExportTarget& target) {
  SvgOptions options{.palette = input.palette};
  if (input.picture != nullptr) {
    options.widthPixels = input.picture->widthPixels;
    options.heightPixels = input.picture->heightPixels;
    options.hasBackground = input.picture->background == PictureBackground::Model;
    options.frame = input.picture->frame;
  }
  writeSvg(input.scene, input.view, options, target.sink);
  return std::nullopt;
}

std::optional<std::string> exportPostScript(const ExportInput& input, const ExportTarget& target) {
  PostScriptOptions options{.palette = input.palette};
  if (input.picture != nullptr) {
    options.frame = input.picture->frame;
  }
  writePostScript(input.scene, input.view, options, target.sink);
  return std::nullopt;
}

std::optional<std::string> exportPng(const PlacedScenes& placed, const ExportTarget& target) {
  const ExportInput& first = placed.scenes[0];
  const PictureOptions options = first.picture != nullptr ? *first.picture : PictureOptions{};
  if (!options.draw) {
    return writePng(renderPlaced(placed, options, target.progress), target.sink, options.maximumColours);
  }
  PictureImage image;
  const auto problem = options.draw(placed, options, image, target.progress);
  return problem ? problem : writePng(image, target.sink, options.maximumColours);
}

// the entry of a format that holds copies of scenes; one for looking at also shows the view file's background scene
template <std::optional<std::string> (*kWrite)(const PlacedScenes&, const ExportTarget&), bool kShowsBackground = true>
constexpr ExportFormat placedFormat(std::string_view name, std::string_view suffix, std::string_view summary) {
  ExportFormat format{name, suffix, summary, nullptr};
  format.write = [](const ExportInput& input, const ExportTarget& target) {
    const ScenePlacement here;
    if (!kShowsBackground || input.view.background == nullptr) {
      return kWrite({{&input, 1}, {&here, 1}}, target);
    }
    const BackgroundDrawing background(*input.view.background);
    const std::array scenes{input, background.input(input)};
    const std::array placements{here, ScenePlacement{.scene = 1}};
    return kWrite({scenes, placements}, target);
  };
  format.writePlaced = kWrite;
  return format;
}

constexpr ExportFormat usdaFormat() {
  ExportFormat format = placedFormat<exportUsda>("usda", ".usda", "a USD stage in text; also of a growing plant");
  format.beginGrowth = beginUsdaGrowth;
  return format;
}

constexpr std::array kFormats = {
    placedFormat<exportPng>("png", ".png", "a shaded picture of points"),
    ExportFormat{"svg", ".svg", "a drawing of lines and areas for web pages", exportSvg},
    ExportFormat{"eps", ".eps", "a drawing of lines and areas for print (PostScript)", exportPostScript},
    ExportFormat{"ps", ".ps", "the same with another suffix", exportPostScript},
    placedFormat<exportGlb>("glb", ".glb", "meshes, materials and repeated organs (binary glTF 2.0)"),
    placedFormat<exportObj>("obj", ".obj", "triangles and quads for 3-D programs, with a .mtl of colours"),
    placedFormat<exportPly, false>("ply", ".ply", "a mesh whose vertices know plant, module and order (binary)"),
    placedFormat<exportStl, false>("stl", ".stl", "triangles only, for printing (binary)"),
    usdaFormat(),
    placedFormat<exportVtp, false>("vtp", ".vtp", "a mesh with module, order and parameters, for ParaView (VTK)"),
    placedFormat<exportVtu, false>("vtu", ".vtu", "the same as an unstructured grid (VTK)"),
    ExportFormat{"mtg", ".mtg", "a multiscale tree graph with geometry, for plant science", writeMtg, nullptr,
                 ExportSource::Modules},
    ExportFormat{"rsml", ".rsml", "axes, diameters and growth of root systems (Root System Markup Language)", writeRsml,
                 beginRsmlGrowth},
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
