#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <utility>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/output/field_outputs.h"
#include "clients/espalier/result.h"
#include "engine/core/number_text.h"
#include "environment/output/field_output.h"
#include "server/remote/disk_files.h"
#include "server/remote/terrain/terrain_embedding.h"

namespace espalier::command {
namespace {

struct FieldOptions {
  std::string file;
  FieldOutputs outputs;
  bool isQuiet = false;
};

// the fields of a .vti file, of a .raw file with its header, or the heights of a GeoTIFF
Result<std::vector<turtle::Field>> readFields(const std::string& file) {
  server::DiskFileProvider files;
  const auto content = files.read(file);
  if (!content) {
    return problem("there is no file '" + file + "': check the name and the working folder");
  }
  const auto located = [&](const std::string& fault) { return file + ": the file " + fault; };
  const std::filesystem::path suffix = std::filesystem::path(file).extension();
  if (suffix == ".tif" || suffix == ".tiff") {
    return server::readGeoTiff(*content).map_error(located).map(
        [](const server::Terrain& terrain) { return std::vector{server::heightsOf(terrain)}; });
  }
  if (suffix != ".raw") {
    return environment::readVti(*content).map_error(located);
  }
  const auto header = files.read(file + ".json");
  if (!header) {
    return problem("there is no header '" + file + ".json' beside '" + file +
                   "': it gives the number of cells and their place");
  }
  auto field = environment::readRaw(*header, *content);
  if (!field) {
    return problem(located(field.error()));
  }
  return std::vector{std::move(*field)};
}

int run(FieldOptions& options) {
  if (!options.outputs.parse()) {
    return kUsage;
  }
  const auto read = readFields(options.file);
  if (!read) {
    printError(read.error());
    return kFailure;
  }
  const std::vector<turtle::Field>& fields = *read;
  std::string table = "field\tunit\tcells\tminimum\tmean\tmaximum\tintegral\n";
  for (const turtle::Field& field : fields) {
    const environment::FieldSummary summary = environment::summaryOf(field);
    table += field.name + "\t" + field.unit + "\t" + std::to_string(field.cells[0]) + "x" +
             std::to_string(field.cells[1]) + "x" + std::to_string(field.cells[2]);
    for (const double number : {summary.minimum, summary.mean, summary.maximum, summary.integral}) {
      table += "\t";
      core::appendNumber(table, number, core::NumberStyle::Shortest);
    }
    table += "\n";
    if (summary.count < field.values.size() && !options.isQuiet) {
      printNote("'" + field.name + "' has no number in " + std::to_string(field.values.size() - summary.count) +
                " of " + std::to_string(field.values.size()) + " cells; mean and integral are those of the others");
    }
  }
  std::cout << table << std::flush;
  return options.outputs.write(fields, options.isQuiet) ? kSuccess : kFailure;
}

}  // namespace

void addField(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("field", "Describe a file of a quantity in space, or write slices of it");
  command->footer(
      "Prints a table of the quantities in the file: cells, least, mean and greatest value, integral.\n"
      "Examples:\n"
      "  espalier field water.vti\n"
      "  espalier field water.vti --field waterContent@z=water.png --field waterContent=water.raw");
  auto options = std::make_shared<FieldOptions>();
  command
      ->add_option(
          "FILE", options->file,
          "A .vti file (VTK image data), a .raw file with its header FILE.json, or a GeoTIFF of heights (.tif)")
      ->required();
  options->outputs.addTo(*command);
  command->add_flag("--quiet", options->isQuiet, "Print only errors");
  command->callback([options, &status] { status = run(*options); });
}

}  // namespace espalier::command
