#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/simulation/simulation.h"
#include "engine/turtle/field.h"
#include "environment/output/field_output.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// The option --field [NAME[@VIEW]=]FILE: quantities in space of the environment as files. By the file's suffix: .vti
/// VTK image data, .raw numbers with a JSON header beside them, .png a slice or projection in colours, .csv a row for
/// each step.
class FieldOutputs {
 public:
  void addTo(CLI::App& command);

  /// Reads the specifications. False: one is wrong, an error was written.
  [[nodiscard]] bool parse();
  /// In which the places of the fields are; until it is said, metres.
  void setLengthUnit(const std::string& unit) { lengthUnit_ = unit; }
  /// Begins a run: tables are empty, and with `variant` all files have that number.
  void begin(std::optional<std::uint64_t> variant);
  /// The files without their numbers.
  [[nodiscard]] std::vector<std::string> files() const;
  /// Whether a file is of that quantity alone.
  [[nodiscard]] bool names(std::string_view field) const {
    return std::ranges::any_of(outputs_, [&](const Output& output) { return output.name == field; });
  }
  [[nodiscard]] bool isEmpty() const { return specifications_.empty(); }
  /// Notes the present step in the tables, and with `number` writes the other files with that number. False: an error
  /// was written.
  [[nodiscard]] bool addStep(simulation::Simulation& simulation, std::optional<std::uint64_t> number, bool isQuiet);
  /// Writes the files of the last step, unless every step was written, and the tables.
  [[nodiscard]] bool finish(simulation::Simulation& simulation, bool isEveryStepWritten, bool isQuiet);
  /// Writes the files of a step that may be the last, tables with the rows so far. An environment without fields yet
  /// has none at step 0. False: an error was written.
  [[nodiscard]] bool writeStep(const std::vector<turtle::Field>& fields, std::uint64_t step, bool isNumbered);
  /// Writes fields that do not come from a simulation, tables with one row for each. False: an error was written.
  [[nodiscard]] bool write(const std::vector<turtle::Field>& fields, bool isQuiet);

 private:
  struct Output {
    std::string name;  // of the field; empty: all, or the first
    environment::FieldView view;
    std::string file;
    std::string suffix;
    std::string rows;  // of a table, as text
  };

  static void addRows(Output& output, const std::vector<turtle::Field>& fields, std::uint64_t step);
  [[nodiscard]] bool writeTable(const Output& output, const std::vector<turtle::Field>& fields, bool isQuiet) const;
  [[nodiscard]] bool writeFile(const Output& output, const std::vector<turtle::Field>& fields, const std::string& file,
                               bool isQuiet) const;

  [[nodiscard]] std::string fileOf(const Output& output) const;

  std::vector<std::string> specifications_;
  std::optional<std::uint64_t> variant_;
  std::vector<Output> outputs_;
  std::string lengthUnit_ = "m";
};

}  // namespace espalier::command
