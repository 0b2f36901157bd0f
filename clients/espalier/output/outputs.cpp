#include "clients/espalier/output/outputs.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include "clients/espalier/messages.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/drawing_order.h"
#include "clients/espalier/output/progress_bar.h"
#include "engine/core/elementary.h"
#include "engine/core/number_text.h"
#include "engine/core/streams.h"
#include "engine/turtle/export/picture/png.h"
#include "engine/turtle/scene/scene_bounds.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSnapshot = "snapshot";

std::string snapshotSuffix() {
  return "." + std::string(kSnapshot);
}

// all formats with their suffixes, one line each, for --help and for messages
std::string formatList(bool arePlaced = false) {
  std::string list;
  const auto add = [&list](std::string_view name, std::string_view suffix, std::string_view summary) {
    list += "\n  " + std::string(name) + std::string(name.size() < 9 ? 9 - name.size() : 1, ' ') + std::string(suffix) +
            std::string(suffix.size() < 10 ? 10 - suffix.size() : 1, ' ') + std::string(summary);
  };
  for (const turtle::ExportFormat& format : turtle::exportFormats()) {
    if (!arePlaced || format.writePlaced != nullptr) {
      add(format.name, format.suffix, format.summary);
    }
  }
  if (!arePlaced) {
    add(kSnapshot, snapshotSuffix(), "the complete state; --resume continues from it");
  }
  return list;
}

bool isSnapshot(const OutputOptions& options, const std::string& file) {
  return options.format.empty() ? fs::path(file).extension() == snapshotSuffix() : options.format == kSnapshot;
}

std::string whyNotAFormat(const std::string& name) {
  return name == kSnapshot || turtle::findExportFormat(name) != nullptr
             ? std::string{}
             : "there is no format '" + name + "'. Formats, with the suffixes that choose them:" + formatList();
}

// "WxH"
std::string readSize(const std::string& text, turtle::PictureOptions& picture) {
  const std::size_t cross = text.find('x');
  const auto number = [&](std::string_view digits, int& value) {
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return problem == std::errc() && end == digits.data() + digits.size() && value >= 1 &&
           value <= turtle::kMaximumPicturePixels;
  };
  const std::string_view all = text;
  const bool isGood = cross != std::string::npos && number(all.substr(0, cross), picture.widthPixels) &&
                      number(all.substr(cross + 1), picture.heightPixels);
  return isGood ? std::string{}
                : "'" + text + "' is not a size: give WIDTHxHEIGHT in pixels, each from 1 to " +
                      std::to_string(turtle::kMaximumPicturePixels) + ", as 800x600";
}

// writes a file and its companions, all or none, shows a progress bar and prints a note
bool writeFile(const std::string& file, bool isQuiet,
               const std::function<std::optional<std::string>(const turtle::ExportTarget&)>& write,
               const std::string& what) {
  server::AtomicFile content(file);
  std::map<std::string, std::unique_ptr<server::AtomicFile>> companions;
  ProgressBar bar(!isQuiet);
  turtle::ExportTarget target{
      .fileName = fs::path(file).filename().string(),
      .sink = content,
      .openCompanion = {},
      .progress = [&](std::uint64_t done, std::uint64_t total) { bar.showWriting(file, done, total); }};
  if (content.isRenamed()) {
    target.openCompanion = [&](const std::string& name) -> core::ByteSink& {
      auto& companion = companions[name];
      companion = std::make_unique<server::AtomicFile>(fs::path(file).replace_filename(name).string());
      return *companion;
    };
  }
  std::optional<std::string> problem = write(target);
  bar.clear();
  if (problem) {
    printError("cannot write '" + file + "': " + *problem);
    return false;
  }
  // companions first: a file never refers to a missing file
  problem = content.finish();
  for (auto& [name, companion] : companions) {
    problem = problem ? problem : companion->finish();
  }
  for (auto& [name, companion] : companions) {
    problem = problem ? problem : companion->commit();
  }
  problem = problem ? problem : content.commit();
  if (problem) {
    printError(*problem);
    return false;
  }
  if (!isQuiet) {
    printNote("wrote " + file + " (" + what + ")");
  }
  return true;
}

// two numbers with a comma between them
std::string readSun(const std::string& text, RenderOptions& render) {
  const std::size_t comma = text.find(',');
  const auto number = [&](std::string_view digits, double& value) {
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return problem == std::errc() && end == digits.data() + digits.size() && std::abs(value) <= 360.0;
  };
  const std::string_view all = text;
  const bool isGood = comma != std::string::npos && number(all.substr(0, comma), render.sunElevation) &&
                      number(all.substr(comma + 1), render.sunAzimuth) && render.sunElevation >= 5.0 &&
                      render.sunElevation <= 90.0;
  return isGood ? std::string{}
                : "'" + text +
                      "' is not a place of the sun: give ELEVATION,AZIMUTH in degrees, the elevation from 5 to 90, as "
                      "58,-35";
}

void addRenderOptions(CLI::App& command, OutputOptions& options) {
  const auto turnOn = [&options] {
    options.render.isOn = true;
    options.picture.draw = [&render = options.render](
                               const turtle::PlacedScenes& placed, const turtle::PictureOptions& picture,
                               turtle::PictureImage& image, const turtle::ExportProgress& progress) {
      return renderInDaylight(placed, picture, render, image, progress);
    };
  };
  CLI::Option* render =
      command.add_flag_callback("--render", turnOn,
                                "Draw a PNG in the light of sun and sky: soft shadows, light through leaves. It takes "
                                "seconds to minutes");
  addWholeNumber(command, "--samples", "With --render: samples of a pixel, at most (512); fewer are faster and grainy",
                 1, 65'536, [&options](std::uint64_t count) { options.render.samples = static_cast<int>(count); })
      ->type_name("N")
      ->needs(render);
  command
      .add_option_function<std::string>(
          "--sun",
          [&options](const std::string& text) {
            if (const std::string problem = readSun(text, options.render); !problem.empty()) {
              throw CLI::ValidationError("--sun", problem);
            }
          },
          "With --render: place of the sun in degrees above the horizon, and to the right of the viewer (58,-35)")
      ->type_name("ELEVATION,AZIMUTH")
      ->needs(render);
  command
      .add_option("--view-height", options.render.height,
                  "With --render: the viewer stands this many degrees above the horizon (the view file's, at least 8)")
      ->type_name("DEGREES")
      ->check(numberFrom(-89.0, 89.0))
      ->needs(render);
}

}  // namespace

bool movesViewer(const OutputOptions& options) {
  return options.render.isOn || options.turntable > 0;
}

const turtle::ExportFormat* formatOf(const OutputOptions& options, const std::string& file) {
  return options.format.empty() ? turtle::findExportFormatOfFile(file) : turtle::findExportFormat(options.format);
}

void addOutputOptions(CLI::App& command, OutputOptions& options, bool isOutputRequired, bool arePlaced) {
  command.add_option("-o,--output", options.files, "Output file; its suffix chooses the format. May be repeated")
      ->type_name("FILE")
      ->required(isOutputRequired)
      ->allow_extra_args(false);
  command
      .add_option("--format", options.format,
                  "Format of all output files, instead of their suffixes:" + formatList(arePlaced))
      ->type_name("NAME")
      ->check([](const std::string& name) { return whyNotAFormat(name); });
  command
      .add_option_function<std::string>(
          "--size",
          [&options](const std::string& text) {
            if (const std::string problem = readSize(text, options.picture); !problem.empty()) {
              throw CLI::ValidationError("--size", problem);
            }
          },
          "Width and height of pictures in pixels (800x600)")
      ->type_name("WxH");
  const std::map<std::string, turtle::PictureBackground> backgrounds{
      {"model", turtle::PictureBackground::Model},
      {"white", turtle::PictureBackground::White},
      {"transparent", turtle::PictureBackground::Transparent}};
  command
      .add_option_function<std::string>(
          "--background",
          [&options, backgrounds](const std::string& name) { options.picture.background = backgrounds.at(name); },
          "Background of a PNG: model (colour 0 of its map or material), white or transparent")
      ->check(CLI::IsMember({"model", "white", "transparent"}));
  command
      .add_option_function<std::string>(
          "--framing",
          [&options](const std::string& name) {
            options.picture.framing = name == "view" ? turtle::PictureFraming::View : turtle::PictureFraming::Fitted;
          },
          "Part of the scene in a PNG: fitted (everything) or view (box, scale factor and viewing angle of the view "
          "file)")
      ->check(CLI::IsMember({"fitted", "view"}));
  command.add_flag(
      "--rainbow", options.isColouredByOrder,
      "Colour the lines by the order in which they are drawn: red, orange, yellow, green, blue, purple, red");
  addWholeNumber(command, "--colours", "Largest number of colours in a PNG, for a small file", 2, 256,
                 [&options](std::uint64_t count) { options.picture.maximumColours = static_cast<int>(count); })
      ->type_name("N");
  addRenderOptions(command, options);
  command.add_flag(
      "--instancing", options.usesInstancing,
      "In a .glb write equal organs, and equal plants of a forest, as one node (EXT_mesh_gpu_instancing). The\n"
      "file is small; not every program reads it");
  command
      .add_option("--detail", options.detail,
                  "Level of detail: factor for the sides of tubes and the subdivisions of surfaces (1)")
      ->type_name("FACTOR")
      ->check(numberFrom(0.01, 100.0));
}

int checkOutputs(const OutputOptions& options) {
  for (const std::string& file : options.files) {
    const fs::path folder = fs::path(file).parent_path();
    std::error_code error;
    if (formatOf(options, file) == nullptr && !isSnapshot(options, file)) {
      printError("'" + file +
                 "' has no known suffix: give one of these, or choose a format with --format:" + formatList());
      return kUsage;
    }
    if (!folder.empty() && !fs::is_directory(folder, error)) {
      printError("cannot write '" + file + "': there is no folder '" + folder.string() + "'; make it first");
      return kFailure;
    }
    if (fs::is_directory(file, error)) {
      printError("cannot write '" + file + "': it is a folder; give the name of a file");
      return kFailure;
    }
  }
  return kSuccess;
}

int checkPlacedOutputs(const OutputOptions& options) {
  std::string formats;
  for (const turtle::ExportFormat& format : turtle::exportFormats()) {
    formats += format.writePlaced == nullptr ? "" : (formats.empty() ? "" : ", ") + std::string(format.suffix);
  }
  for (const std::string& file : options.files) {
    const turtle::ExportFormat* const format = formatOf(options, file);
    if (isSnapshot(options, file) || (format != nullptr && format->writePlaced == nullptr)) {
      printError("'" + file + "' cannot hold several plants side by side: give one of " + formats);
      return kUsage;
    }
  }
  return checkOutputs(options);
}

std::string numberedName(const std::string& file, std::uint64_t number, int digits) {
  const auto padded = [number](int width) {
    std::string text = std::to_string(number);
    return text.size() < static_cast<std::size_t>(width)
               ? std::string(static_cast<std::size_t>(width) - text.size(), '0') + text
               : text;
  };
  // %d or %0Nd, as in printf
  if (const std::size_t percent = file.find('%'); percent != std::string::npos) {
    std::size_t end = percent + 1;
    int width = 0;
    while (end < file.size() && file[end] >= '0' && file[end] <= '9' && width < 100) {
      width = width * 10 + (file[end] - '0');
      ++end;
    }
    if (end < file.size() && file[end] == 'd') {
      return file.substr(0, percent) + padded(width) + file.substr(end + 1);
    }
  }
  const fs::path path(file);
  return fs::path(path)
      .replace_filename(path.stem().string() + "-" + padded(digits) + path.extension().string())
      .string();
}

/// The drawing that all files share.
struct OutputWriter::Drawn {
  turtle::Scene scene;
  files::Palette palette;
};

std::optional<OutputWriter::Drawn> OutputWriter::drawn(const simulation::Simulation& simulation) const {
  auto scene = simulation.scene();
  if (!scene) {
    printError(formatSimulationError(scene.error()));
    return std::nullopt;
  }
  Drawn drawn{.scene = std::move(*scene), .palette = simulation.options().palette};
  if (options_.isColouredByOrder) {
    drawn.palette = colourByDrawingOrder(drawn.scene);
  }
  return drawn;
}

bool OutputWriter::write(const simulation::Simulation& simulation, std::optional<std::uint64_t> number,
                         int digits) const {
  bool needsScene = false;
  for (const std::string& file : options_.files) {
    const turtle::ExportFormat* const format = formatOf(options_, file);
    needsScene = needsScene || (format != nullptr && format->source == turtle::ExportSource::Scene);
  }
  std::optional<Drawn> all =
      needsScene ? drawn(simulation) : Drawn{.scene = {}, .palette = simulation.options().palette};
  // of the files of many steps the first ones may well be empty
  if (all && needsScene && all->scene.empty() && !number && !isQuiet_) {
    printNote(
        "warning: nothing is drawn. F(1) draws a line of the length 1; the section "
        "'homomorphism:' says how other modules are drawn, as I(x) --> F(x)");
  }
  return all && std::ranges::all_of(options_.files, [&](const std::string& file) {
           return writeOne(simulation, *all, number ? numberedName(file, *number, digits) : file, file);
         });
}

std::string_view lengthUnitOf(const OutputOptions& options, const simulation::Simulation& simulation) {
  static const turtle::World kDefault;
  const std::string& unit = simulation.options().world.lengthUnit;
  return options.lengthUnit.empty() && unit == kDefault.lengthUnit ? std::string_view() : std::string_view(unit);
}

std::optional<std::string> OutputWriter::picture(const simulation::Simulation& simulation) const {
  const std::optional<Drawn> all = drawn(simulation);
  if (!all) {
    return std::nullopt;
  }
  core::StringSink sink;
  const turtle::ExportTarget target{.fileName = "picture.png", .sink = sink, .openCompanion = {}, .progress = {}};
  if (const auto problem = exportTo(simulation, *all, *turtle::findExportFormat("png"), target)) {
    printError("cannot draw step " + std::to_string(simulation.completedSteps()) + ": " + *problem);
    return std::nullopt;
  }
  return sink.take();
}

void OutputWriter::warnIfFar(const turtle::Scene& scene, const files::ViewSettings& view,
                             const turtle::ExportFormat& format) const {
  constexpr std::array<std::string_view, 6> kMeshes{"glb", "obj", "ply", "stl", "usda", "vtp"};
  constexpr double kFine = 1e-4;  // of the size of the scene
  const auto largestOf = [](const core::Vec3& place) {
    return std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)});
  };
  // of a scene that is far away each line is
  const bool mayBeFar = scene.segments.empty() || largestOf(scene.segments[0].start) > 100.0;
  if (isQuiet_ || hasWarned_ || !mayBeFar || std::ranges::find(kMeshes, format.name) == kMeshes.end()) {
    return;
  }
  const auto box = turtle::boundsOf(scene, view);
  if (!box) {
    return;
  }
  const double largest = std::max(largestOf(box->minimum), largestOf(box->maximum));
  // between neighbouring numbers of single precision
  const double step = core::exp2(std::floor(core::log2(largest)) - 23.0);
  if (step > kFine * largestOf(box->maximum - box->minimum)) {
    std::string text;
    core::appendNumber(text, step, core::NumberStyle::Shortest);
    printNote("warning: the plants are far from 0, and meshes have single precision: their points lie on steps of " +
              text + ". Subtract an origin from the places of the plants");
    hasWarned_ = true;
  }
}

std::optional<std::string> OutputWriter::exportTo(const simulation::Simulation& simulation, const Drawn& drawn,
                                                  const turtle::ExportFormat& format,
                                                  const turtle::ExportTarget& target) const {
  std::vector<const derivation::ModuleString*> strings;
  std::vector<const language::Program*> programs;
  std::vector<std::span<const std::uint64_t>> births;
  for (std::size_t plant = 0; plant < simulation.plantCount(); ++plant) {
    births.push_back(simulation.moduleBirths(plant));
    strings.push_back(&simulation.string(plant));
    programs.push_back(&simulation.program(plant));
  }
  const auto visitModules = [&simulation](const turtle::ModuleVisitor& visit) -> std::optional<std::string> {
    if (const auto failure = simulation.visitModules(visit)) {
      return formatSimulationError(*failure);
    }
    return std::nullopt;
  };
  warnIfFar(drawn.scene, simulation.view(), format);
  std::optional<files::ViewSettings> moved;
  if (movesViewer(options_) && format.name == "png") {
    moved = viewToRender(simulation.view(), options_.render);
  }
  const turtle::ExportInput input{.scene = drawn.scene,
                                  .view = moved ? *moved : simulation.view(),
                                  .palette = &drawn.palette,
                                  .detail = options_.detail,
                                  .threads = options_.picture.threads,
                                  .usesInstancing = options_.usesInstancing,
                                  .picture = &options_.picture,
                                  .step = simulation.completedSteps(),
                                  .lengthUnit = lengthUnitOf(options_, simulation),
                                  .stepDurationDays = simulation.options().world.stepDurationDays,
                                  .rsml = options_.rootLabels.get(),
                                  .program = &simulation.program(),
                                  .programs = programs,
                                  .strings = strings,
                                  .births = births,
                                  .visitModules = visitModules};
  return format.write(input, target);
}

bool OutputWriter::writeOne(const simulation::Simulation& simulation, const Drawn& drawn, const std::string& file,
                            const std::string& formatFrom) const {
  const auto write = [&](const turtle::ExportTarget& target) -> std::optional<std::string> {
    if (isSnapshot(options_, formatFrom)) {
      simulation.save(target.sink);
      return std::nullopt;
    }
    return exportTo(simulation, drawn, *formatOf(options_, formatFrom), target);
  };
  return writeFile(file, isQuiet_, write,
                   "step " + std::to_string(simulation.completedSteps()) + ", " +
                       std::to_string(simulation.statistics().modules) + " modules");
}

bool writePlacedFiles(const OutputOptions& options, std::span<turtle::ExportInput> scenes,
                      std::span<const turtle::ScenePlacement> placements, const std::string& what, bool isQuiet) {
  for (turtle::ExportInput& scene : scenes) {
    scene.detail = options.detail;
    scene.threads = options.picture.threads;
    scene.picture = &options.picture;
    scene.usesInstancing = options.usesInstancing;
  }
  for (const std::string& file : options.files) {
    const auto write = [&](const turtle::ExportTarget& target) {
      return formatOf(options, file)->writePlaced({scenes, placements}, target);
    };
    if (!writeFile(file, isQuiet, write, what)) {
      return false;
    }
  }
  return true;
}

bool writePicture(const OutputOptions& options, const turtle::PictureImage& picture, const std::string& file,
                  const std::string& what, bool isQuiet) {
  const auto write = [&](const turtle::ExportTarget& target) {
    return turtle::writePng(picture, target.sink, options.picture.maximumColours);
  };
  return writeFile(file, isQuiet, write, what);
}

}  // namespace espalier::command
