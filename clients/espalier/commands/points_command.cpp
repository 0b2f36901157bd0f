#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <memory>
#include <utility>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/field_outputs.h"
#include "clients/espalier/result.h"
#include "engine/core/number_text.h"
#include "environment/output/point_embedding.h"
#include "environment/output/point_voxels.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

using core::Vec3;

constexpr double kMostCells = 10'000'000.0;

struct PointsOptions {
  std::string file;
  FieldOutputs outputs;
  environment::PointPlacement placement;
  std::vector<double> origin, scanner;  // x, y, z; empty: not given
  std::vector<int> classes;             // of points of plants; empty: all
  double cellSize = 0.0;
  double projection = 0.5;
  bool isQuiet = false;
};

Vec3 vectorOf(const std::vector<double>& numbers) {
  return numbers.empty() ? Vec3{} : Vec3{numbers[0], numbers[1], numbers[2]};
}

struct Extent {
  Vec3 low, high;
};

Extent extentOf(const std::vector<Vec3>& points) {
  Extent extent{points.front(), points.front()};
  for (const Vec3& p : points) {
    extent.low = {std::min(extent.low.x, p.x), std::min(extent.low.y, p.y), std::min(extent.low.z, p.z)};
    extent.high = {std::max(extent.high.x, p.x), std::max(extent.high.y, p.y), std::max(extent.high.z, p.z)};
  }
  return extent;
}

/// Points, extent, unit and classes of a file.
std::string tableOf(const files::PointCloud& cloud) {
  std::string table = "property\tvalue\npoints\t" + std::to_string(cloud.points.size()) + "\nunit\t" +
                      (cloud.lengthUnit.empty() ? "unknown" : cloud.lengthUnit) + "\n";
  if (!cloud.points.empty()) {
    const Extent extent = extentOf(cloud.points);
    for (const auto& [name, place] : {std::pair{"minimum", extent.low}, {"maximum", extent.high}}) {
      table += name;
      for (const double number : {place.x, place.y, place.z}) {
        table += '\t';
        core::appendNumber(table, number, core::NumberStyle::Shortest);
      }
      table += '\n';
    }
  }
  std::array<std::size_t, 256> counts{};
  for (const std::uint8_t each : cloud.classes) {
    ++counts[each];
  }
  for (std::size_t each = 0; each < counts.size(); ++each) {
    if (counts[each] > 0) {
      table += "class " + std::to_string(each) + "\t" + std::to_string(counts[each]) + "\n";
    }
  }
  return table;
}

/// The cells around all points: their faces are at whole multiples of the size.
Result<environment::VoxelBox> boxAround(const std::vector<Vec3>& points, double size) {
  const Extent extent = extentOf(points);
  environment::VoxelBox box{.position = {}, .cellSize = {size, size, size}, .cells = {1, 1, 1}};
  double cells = 1.0;
  std::array<double, 3> corner{};
  const std::array<std::pair<double, double>, 3> ranges{
      {{extent.low.x, extent.high.x}, {extent.low.y, extent.high.y}, {extent.low.z, extent.high.z}}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double first = std::floor(ranges[axis].first / size);
    const double count = std::floor(ranges[axis].second / size) - first + 1.0;
    corner[axis] = first * size;
    cells *= count;
    if (!(cells <= kMostCells)) {
      return problem("the points fill more than 10000000 cells of that size: choose a larger --cell-size");
    }
    box.cells[axis] = static_cast<std::size_t>(count);
  }
  box.position = {corner[0], corner[1], corner[2]};
  return box;
}

Result<std::vector<turtle::Field>> fieldsOf(const PointsOptions& options, files::PointCloud cloud) {
  if (options.scanner.empty() && (options.outputs.names("gapFraction") || options.outputs.names("leafAreaDensity"))) {
    return problem(
        "the file does not say where its pulses came from, so gaps and leaf area cannot be told from unseen "
        "space: give the place of the scanner with --scanner X,Y,Z, in the file's coordinates");
  }
  if (!(options.cellSize > 0.0)) {
    return problem("give the size of the cells with --cell-size");
  }
  std::vector<std::uint8_t> isPlant;
  if (!options.classes.empty()) {
    if (cloud.classes.empty()) {
      return problem(options.file + ": the file has no classes, so --classes cannot choose");
    }
    for (const std::uint8_t each : cloud.classes) {
      isPlant.push_back(std::ranges::find(options.classes, int{each}) != options.classes.end() ? 1 : 0);
    }
    if (std::ranges::find(isPlant, 1) == isPlant.end()) {
      return problem(options.file + ": no point is of the classes of --classes; espalier points " + options.file +
                     " lists those of the file");
    }
  }
  environment::placePoints(cloud, options.placement);
  const auto box = boxAround(cloud.points, options.cellSize);
  if (!box) {
    return tl::unexpected(box.error());
  }
  const environment::ScannedPoints points{.places = cloud.points, .returns = cloud.returns, .isPlant = isPlant};
  std::vector<turtle::Field> fields{environment::countPoints(points, *box)};
  if (!options.scanner.empty()) {
    files::PointCloud place;
    place.points = {vectorOf(options.scanner)};
    place.isNorthEastUp = cloud.isNorthEastUp;
    environment::placePoints(place, options.placement);
    for (turtle::Field& field : environment::tracePulses(points, *box, place.points[0], options.projection)) {
      fields.push_back(std::move(field));
    }
  }
  return fields;
}

int run(PointsOptions& options) {
  if (!options.outputs.parse()) {
    return kUsage;
  }
  const auto bytes = server::DiskFileProvider().read(options.file);
  if (!bytes) {
    printError("there is no file '" + options.file + "': check the name and the working folder");
    return kFailure;
  }
  auto cloud = files::readPoints(*bytes);
  if (!cloud) {
    printError(options.file + ": the file " + cloud.error());
    return kFailure;
  }
  const std::string table = tableOf(*cloud);
  if (!options.outputs.isEmpty()) {
    if (cloud->points.empty()) {
      printError(options.file + ": the file has no points, so there are no cells: choose another file");
      return kFailure;
    }
    options.placement.origin = vectorOf(options.origin);
    const auto fields = fieldsOf(options, std::move(*cloud));
    if (!fields) {
      printError(fields.error());
      return kFailure;
    }
    if (!options.outputs.write(*fields, options.isQuiet)) {
      return kFailure;
    }
  }
  std::cout << table << std::flush;
  return kSuccess;
}

}  // namespace

void addPoints(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("points", "Describe a point cloud, or count its points in cells");
  command->footer(
      "Prints points, unit, extent and classes of a LAS or PLY file. With --field it writes pointCount for each cell "
      "and,\n"
      "where --scanner is given, pulses, gapFraction and leafAreaDensity. East is x, up is y, south is z of a LAS "
      "file.\n"
      "Examples:\n"
      "  espalier points scan.las\n"
      "  espalier points scan.las --cell-size 0.5 --field counts.vti\n"
      "  espalier points scan.las --cell-size 0.5 --scanner 3.5,0,1.6 --classes 3,4,5 --field "
      "leafAreaDensity=leaves.vti");
  auto options = std::make_shared<PointsOptions>();
  command->add_option("FILE", options->file, "A LAS file (1.2 to 1.4) or a PLY file")->required();
  options->outputs.addTo(*command);
  addPositiveNumber(*command, "--cell-size", "Edge of a cell, in the unit that the lengths have after --scale",
                    "a length", [options](double size) { options->cellSize = size; });
  command->add_option("--origin", options->origin, "The point of the file that comes to the origin")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3);
  addPositiveNumber(*command, "--scale", "Factor of all lengths (1)", "a factor",
                    [options](double scale) { options->placement.scale = scale; });
  command
      ->add_option_function<std::string>(
          "--axes", [options](const std::string& axes) { options->placement.keepsAxes = axes == "file"; },
          "world: a LAS file is turned so that up is y; file: its axes stay (world)")
      ->check(CLI::IsMember({"world", "file"}));
  command->add_option("--scanner", options->scanner, "Where all pulses came from, in the file's coordinates")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3);
  command
      ->add_option("--classes", options->classes, "Classes of LAS that are plants; the others only stop pulses (all)")
      ->type_name("N,N,...")
      ->delimiter(',');
  addPositiveNumber(*command, "--projection", "Projected area of a unit of leaf area, G (0.5)", "a number",
                    [options](double projection) { options->projection = projection; });
  command->add_flag("--quiet", options->isQuiet, "Print only results and errors");
  command->callback([options, &status] { status = run(*options); });
}

}  // namespace espalier::command
