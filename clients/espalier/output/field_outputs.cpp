#include "clients/espalier/output/field_outputs.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "clients/espalier/messages.h"
#include "clients/espalier/output/outputs.h"
#include "engine/core/number_text.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/export/picture/png.h"
#include "environment/output/field_picture.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

constexpr const char* kNoField =
    ": the environment holds no quantity in space: choose one that does, such as soil-water or light-voxels";

using turtle::Field;

std::string numberText(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

std::string listOf(const std::vector<Field>& fields) {
  std::string list;
  for (const Field& field : fields) {
    list += (list.empty() ? "" : ", ") + field.name;
  }
  return list;
}

// "x", "y" or "z", then perhaps ":" and a coordinate
std::optional<environment::FieldView> readView(const std::string& text) {
  const std::size_t axis = text.empty() ? std::string::npos : std::string("xyz").find(text[0]);
  if (axis == std::string::npos) {
    return std::nullopt;
  }
  environment::FieldView view{static_cast<int>(axis), std::nullopt};
  if (text.size() > 1) {
    view.at = core::parseNumber(std::string_view(text).substr(2));
    if (text[1] != ':' || !view.at) {
      return std::nullopt;
    }
  }
  return view;
}

// a figure, and what its colours mean
std::optional<std::string> writePicture(const Field& field, const environment::FieldView& view, const std::string& file,
                                        std::string& remark) {
  auto viewed = environment::viewField(field, view);
  if (!viewed) {
    return std::move(viewed.error());
  }
  const environment::FieldPlane& plane = *viewed;
  const auto [low, high] = environment::rangeOf(plane);
  remark = ", dark blue " + numberText(low) + " to yellow " + numberText(high) + " " + field.unit;
  core::StringSink bytes;
  if (auto problem = turtle::writePng(environment::drawField(field, view, plane), bytes)) {
    return problem;
  }
  return server::writeFileAtomically(file, bytes.text());
}

}  // namespace

void FieldOutputs::addTo(CLI::App& command) {
  command
      .add_option("--field", specifications_,
                  "Write quantities in space of the environment, such as water in the soil. Formats by suffix:\n"
                  "  .vti  VTK image data, all quantities or NAME   .raw  numbers, with a header FILE.json\n"
                  "  .png  NAME, mean along @x, @y or @z, or a slice as @z:0.5\n"
                  "  .csv  least, mean and greatest value and integral in each step")
      ->type_name("[NAME[@VIEW]=]FILE");
}

bool FieldOutputs::parse() {
  outputs_.clear();
  for (const std::string& specification : specifications_) {
    Output output;
    const std::size_t equal = specification.find('=');
    output.file = equal == std::string::npos ? specification : specification.substr(equal + 1);
    output.name = equal == std::string::npos ? "" : specification.substr(0, equal);
    if (const std::size_t at = output.name.find('@'); at != std::string::npos) {
      const auto view = readView(output.name.substr(at + 1));
      if (!view) {
        printError("--field " + specification + ": there is no view '" + output.name.substr(at + 1) +
                   "': write x, y or z for the mean along an axis, or z:0.5 for a slice");
        return false;
      }
      output.view = *view;
      output.name.resize(at);
    }
    output.suffix = std::filesystem::path(output.file).extension().string();
    if (output.suffix != ".vti" && output.suffix != ".raw" && output.suffix != ".png" && output.suffix != ".csv") {
      const bool isOfPython = output.suffix == ".nc" || output.suffix == ".zarr";
      printError("--field " + specification + ": a field is written as .vti, .raw, .png or .csv; choose one of these" +
                 (isOfPython
                      ? ", and make the other file by `python3 -m espalier.fields FILE.vti OUT" + output.suffix + "`"
                      : ""));
      return false;
    }
    outputs_.push_back(std::move(output));
  }
  return true;
}

bool FieldOutputs::writeFile(const Output& output, const std::vector<Field>& fields, const std::string& file,
                             bool isQuiet) const {
  std::vector<Field> chosen;
  for (const Field& field : fields) {
    const bool fits = chosen.empty() || (output.suffix == ".vti" && field.cells == chosen.front().cells &&
                                         field.position == chosen.front().position);
    if ((output.name.empty() || output.name == field.name) && fits) {
      chosen.push_back(field);
    }
  }
  if (chosen.empty()) {
    printError(fields.empty()
                   ? "--field " + file + kNoField
                   : "--field " + file + ": there is no field '" + output.name + "'. There are: " + listOf(fields));
    return false;
  }
  std::string remark = " (" + listOf(chosen) + ")";
  std::optional<std::string> problem;
  if (output.suffix == ".vti") {
    problem = server::writeFileAtomically(file, environment::writeVti(chosen, lengthUnit_));
  } else if (output.suffix == ".raw") {
    problem = server::writeFileAtomically(file, environment::writeRaw(chosen.front()));
    problem =
        problem ? problem : server::writeFileAtomically(file + ".json", environment::writeRawHeader(chosen.front()));
  } else {
    std::string range;
    problem = writePicture(chosen.front(), output.view, file, range);
    remark += range;
  }
  if (problem) {
    printError(*problem);
  } else if (!isQuiet) {
    printNote("wrote " + file + remark);
  }
  return !problem;
}

void FieldOutputs::addRows(Output& output, const std::vector<Field>& fields, std::uint64_t step) {
  for (const Field& field : fields) {
    if (output.name.empty() || output.name == field.name) {
      const environment::FieldSummary summary = environment::summaryOf(field);
      output.rows += std::to_string(step) + "," + field.name + "," + field.unit + "," + numberText(summary.minimum) +
                     "," + numberText(summary.mean) + "," + numberText(summary.maximum) + "," +
                     numberText(summary.integral) + "\n";
    }
  }
}

bool FieldOutputs::writeTable(const Output& output, const std::vector<Field>& fields, bool isQuiet) const {
  if (output.rows.empty()) {
    printError("--field " + output.file +
               (fields.empty() ? kNoField : ": there is no field '" + output.name + "'. There are: " + listOf(fields)));
    return false;
  }
  const std::string header = "step,field,unit,minimum,mean,maximum,integral\n";
  if (const auto problem = server::writeFileAtomically(fileOf(output), header + output.rows)) {
    printError(*problem);
    return false;
  }
  if (!isQuiet) {
    printNote("wrote " + fileOf(output));
  }
  return true;
}

void FieldOutputs::begin(std::optional<std::uint64_t> variant) {
  variant_ = variant;
  for (Output& output : outputs_) {
    output.rows.clear();
  }
}

std::vector<std::string> FieldOutputs::files() const {
  std::vector<std::string> files;
  std::transform(outputs_.begin(), outputs_.end(), std::back_inserter(files),
                 [this](const Output& output) { return fileOf(output); });
  return files;
}

std::string FieldOutputs::fileOf(const Output& output) const {
  return variant_ ? numberedName(output.file, *variant_, 3) : output.file;
}

bool FieldOutputs::addStep(simulation::Simulation& simulation, std::optional<std::uint64_t> number, bool isQuiet) {
  const bool hasTable =
      std::any_of(outputs_.begin(), outputs_.end(), [](const Output& output) { return output.suffix == ".csv"; });
  if (outputs_.empty() || (!number && !hasTable)) {
    return true;
  }
  setLengthUnit(simulation.options().world.lengthUnit);
  const std::vector<Field> fields =
      simulation.environment() == nullptr ? std::vector<Field>{} : simulation.environment()->fields();
  for (Output& output : outputs_) {
    if (output.suffix == ".csv") {
      addRows(output, fields, simulation.completedSteps());
    } else if (number && !writeFile(output, fields, numberedName(fileOf(output), *number, 4), isQuiet)) {
      return false;
    }
  }
  return true;
}

bool FieldOutputs::finish(simulation::Simulation& simulation, bool isEveryStepWritten, bool isQuiet) {
  if (outputs_.empty()) {
    return true;
  }
  setLengthUnit(simulation.options().world.lengthUnit);
  const std::vector<Field> fields =
      simulation.environment() == nullptr ? std::vector<Field>{} : simulation.environment()->fields();
  return std::all_of(outputs_.begin(), outputs_.end(), [&](const Output& output) {
    return output.suffix == ".csv" ? writeTable(output, fields, isQuiet)
                                   : isEveryStepWritten || writeFile(output, fields, fileOf(output), isQuiet);
  });
}

bool FieldOutputs::writeStep(const std::vector<Field>& fields, std::uint64_t step, bool isNumbered) {
  if (step == 0 && fields.empty()) {
    return true;
  }
  return std::all_of(outputs_.begin(), outputs_.end(), [&](Output& output) {
    if (output.suffix == ".csv") {
      addRows(output, fields, step);
      return writeTable(output, fields, true);
    }
    return writeFile(output, fields, isNumbered ? numberedName(output.file, step, 4) : output.file, true);
  });
}

bool FieldOutputs::write(const std::vector<Field>& fields, bool isQuiet) {
  for (Output& output : outputs_) {
    if (output.suffix == ".csv") {
      addRows(output, fields, 0);
    }
    if (!(output.suffix == ".csv" ? writeTable(output, fields, isQuiet)
                                  : writeFile(output, fields, output.file, isQuiet))) {
      return false;
    }
  }
  return true;
}

}  // namespace espalier::command
