#include <algorithm>
#include <optional>
#include <utility>

#include "environment/base/process_entry.h"
#include "environment/multiple.h"
#include "environment/published/field_file.h"
#include "environment/published/field_text.h"
#include "environment/published/text_exchange.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

using core::Diagnostic;
using core::Severity;
using core::SourceLocation;

constexpr std::string_view kFieldFileKeyword = "field communication file";

/// A specification file as a configuration, and where each key was written.
struct Specification {
  ConfigurationValues values;
  std::map<std::string, SourceLocation> locations;  // by key
};

class SpecificationReader {
 public:
  SpecificationReader(const ProcessEntry& process, core::FileProvider& files, std::vector<Diagnostic>& warnings,
                      std::vector<Diagnostic>& errors)
      : process_(process), files_(files), warnings_(warnings), errors_(errors) {}

  Specification read(const std::string& file, std::string_view text) {
    for (const FieldLine& line : readFieldLines(file, text, FieldSyntax::Specification, warnings_)) {
      const auto keyword = std::find_if(process_.fieldKeywords.begin(), process_.fieldKeywords.end(),
                                        [&](const FieldKeyword& k) { return k.keyword == line.keyword; });
      if (keyword == process_.fieldKeywords.end()) {
        warnUnknown(line);
      } else {
        readLine(file, line, *keyword);
      }
    }
    return std::move(specification_);
  }

 private:
  void warnUnknown(const FieldLine& line) {
    std::vector<std::string_view> names;
    for (const FieldKeyword& keyword : process_.fieldKeywords) {
      names.push_back(keyword.keyword);
    }
    warn(line.location, "unknown keyword '" + line.keyword + "' of '" + std::string(process_.name) + "' is ignored",
         names.empty() ? "this process reads no specification" : core::suggestName(line.keyword, names));
  }

  void readLine(const std::string& file, const FieldLine& line, const FieldKeyword& keyword) {
    if (keyword.kind == FieldKind::Unused) {
      return;
    }
    if (keyword.kind == FieldKind::Own) {
      readOwn(file, line, keyword);
      return;
    }
    const std::string key(keyword.key);
    specification_.locations.insert_or_assign(key, valueLocation(line));
    if (keyword.kind == FieldKind::Switch) {
      const auto words = keyword.onWords;
      const bool isOn = std::find(words.begin(), words.end(), line.value) != words.end();
      if (!isOn && line.value != "off" && line.value != "no") {
        warn(valueLocation(line), "'" + line.keyword + "' is neither on nor off: taken as off",
             "write '" + std::string(words.front()) + "' or 'off'");
      }
      specification_.values.insert_or_assign(key, isOn);
      return;
    }
    std::string_view rest;
    std::vector<double> numbers = readFieldNumbers(line.value, &rest);
    if (keyword.kind != FieldKind::Row && numbers.size() < keyword.count) {
      errors_.push_back({Severity::Error,
                         "'" + line.keyword + "' needs " +
                             (keyword.count == 1 ? "a number" : std::to_string(keyword.count) + " numbers") +
                             ", found " + (numbers.empty() ? "'" + line.value + "'" : std::to_string(numbers.size())),
                         valueLocation(line),
                         {}});
      return;
    }
    if (numbers.size() > keyword.count || !rest.empty()) {
      warn(valueLocation(line),
           "'" + line.keyword + "': what follows the first " +
               (keyword.count == 1 ? "number" : std::to_string(keyword.count) + " numbers") + " is ignored",
           {});
      numbers.resize(std::min(numbers.size(), keyword.count));
    }
    if (keyword.kind == FieldKind::Number) {
      specification_.values.insert_or_assign(key, numbers.front());
    } else if (keyword.kind == FieldKind::Numbers) {
      specification_.values.insert_or_assign(key, std::move(numbers));
    } else {
      auto& rows = specification_.values.try_emplace(key, ConfigurationRows{}).first->second;
      std::get<ConfigurationRows>(rows).push_back(std::move(numbers));
    }
  }

  void readOwn(const std::string& file, const FieldLine& line, const FieldKeyword& keyword) {
    ConfigurationValues read;
    const std::string problem = keyword.read(FieldLineInput{line, file, files_, read});
    if (!problem.empty()) {
      errors_.push_back({Severity::Error, "'" + line.keyword + "' " + problem, valueLocation(line), {}});
      return;
    }
    for (auto& [key, value] : read) {
      specification_.locations.insert_or_assign(key, valueLocation(line));
      specification_.values.insert_or_assign(key, std::move(value));
    }
  }

  void warn(const SourceLocation& location, std::string message, std::string hint) {
    warnings_.push_back({Severity::Warning, std::move(message), location, std::move(hint)});
  }

  const ProcessEntry& process_;
  core::FileProvider& files_;
  std::vector<Diagnostic>& warnings_;
  std::vector<Diagnostic>& errors_;
  Specification specification_;
};

/// In the compatible modes a process that can behave as the published program does so.
void makeCompatible(const ProcessEntry& process, ConfigurationValues& values) {
  for (const ConfigurationKey& key : process.keys) {
    if (key.name == "compatible") {
      values.insert_or_assign("compatible", true);
    } else if (key.name == "order") {
      values.insert_or_assign("order", std::string("published"));
    }
  }
}

/// Makes the process of one `.e` file; `isField`: it is a field of `multiple`.
ProcessOrErrors makeFromFile(const std::string& file, core::FileProvider& files, core::Compatibility compatibility,
                             bool isField, std::vector<Diagnostic>& warnings);

/// The fields that the specification of `multiple` names, in order.
ProcessOrErrors makeFields(const std::string& file, std::string_view text, core::FileProvider& files,
                           core::Compatibility compatibility, std::vector<Diagnostic>& warnings) {
  std::vector<std::unique_ptr<turtle::EnvironmentProcess>> fields;
  std::vector<Diagnostic> errors;
  for (const FieldLine& line : readFieldLines(file, text, FieldSyntax::Specification, warnings)) {
    if (line.keyword != kFieldFileKeyword) {
      warnings.push_back({Severity::Warning, "unknown keyword '" + line.keyword + "' of 'multiple' is ignored",
                          line.location, core::suggestName(line.keyword, {kFieldFileKeyword})});
      continue;
    }
    auto field = makeFromFile(besideFile(file, line.value), files, compatibility, true, warnings);
    if (auto* wrong = std::get_if<std::vector<Diagnostic>>(&field)) {
      for (Diagnostic& error : *wrong) {
        if (error.location.file.empty()) {
          error.location = valueLocation(line);
        }
        errors.push_back(std::move(error));
      }
    } else {
      fields.push_back(std::get<std::unique_ptr<turtle::EnvironmentProcess>>(std::move(field)));
    }
  }
  if (fields.empty() && errors.empty()) {
    SourceLocation location;
    location.file = file;
    location.line = 1;
    location.column = 1;
    errors.push_back({Severity::Error, "the specification of 'multiple' names no field", location,
                      "expected lines like 'field communication file: light.e'"});
  }
  if (!errors.empty()) {
    return errors;
  }
  return makeMultiple(std::move(fields), compatibility != core::Compatibility::Espalier);
}

/// Checks a specification like any configuration; errors point at its lines.
ProcessOrErrors makeFromSpecification(const ProcessEntry& process, const Specification& specification,
                                      const SourceLocation& executable, std::vector<Diagnostic> errors) {
  auto configuration = readConfiguration(process.name, process.keys, writeConfiguration(specification.values));
  if (auto* wrong = std::get_if<std::vector<ConfigurationError>>(&configuration)) {
    for (ConfigurationError& error : *wrong) {
      const auto location = specification.locations.find(error.key);
      error.diagnostic.location = location == specification.locations.end() ? executable : location->second;
      errors.push_back(std::move(error.diagnostic));
    }
  }
  if (!errors.empty()) {
    return errors;
  }
  auto made = process.make(std::get<Configuration>(configuration));
  if (auto* wrong = std::get_if<std::vector<Diagnostic>>(&made)) {
    // what a process says of its keys together: at the line of the first that it names
    for (Diagnostic& error : *wrong) {
      error.location = executable;
      std::size_t first = std::string::npos;
      for (const auto& [key, location] : specification.locations) {
        const std::size_t at = error.message.find("'" + std::string(key));
        if (at < first) {
          first = at;
          error.location = location;
        }
      }
    }
  }
  return made;
}

ProcessOrErrors makeFromFile(const std::string& file, core::FileProvider& files, core::Compatibility compatibility,
                             bool isField, std::vector<Diagnostic>& warnings) {
  const auto text = files.read(file);
  if (!text) {
    Diagnostic diagnostic;
    diagnostic.message = "cannot read the environment file '" + file + "'";
    diagnostic.hint = "check the name and that the file can be read";
    return std::vector<Diagnostic>{diagnostic};
  }
  std::vector<Diagnostic> errors;
  const FieldFile field = readFieldFile(file, *text, warnings, errors);
  if (field.program.empty() && errors.empty()) {
    errors.push_back(missingProgram(file));
  }
  if (!errors.empty()) {
    return errors;
  }
  const ProcessEntry* process = findProcess(field.program);
  if (process == nullptr) {
    Diagnostic diagnostic = unknownProcess(field.program);
    diagnostic.location = field.executable;
    return std::vector<Diagnostic>{diagnostic};
  }
  const bool isMultiple = process == &kMultipleProcess;
  if (isMultiple && isField) {
    return std::vector<Diagnostic>{{Severity::Error, "a field of 'multiple' cannot be 'multiple' itself",
                                    field.executable, "name its fields in the first specification"}};
  }

  // the specification
  std::string name;
  std::string content;
  if (!field.specification.empty()) {
    name = besideFile(file, field.specification);
    const auto read = files.read(name);
    if (!read) {
      return std::vector<Diagnostic>{{Severity::Error, "cannot read the specification file '" + name + "'",
                                      field.executable, "it is looked for beside the environment file"}};
    }
    content = *read;
  }
  const bool isCompatible = compatibility != core::Compatibility::Espalier;
  ProcessOrErrors made;
  if (isMultiple) {
    made = makeFields(name.empty() ? file : name, content, files, compatibility, warnings);
  } else {
    Specification specification = SpecificationReader(*process, files, warnings, errors).read(name, content);
    if (isCompatible) {
      makeCompatible(*process, specification.values);
    }
    made = makeFromSpecification(*process, specification, field.executable, std::move(errors));
  }
  auto* inside = std::get_if<std::unique_ptr<turtle::EnvironmentProcess>>(&made);
  if (inside != nullptr && isCompatible) {
    return makeTextExchange(std::move(*inside), field.formats);
  }
  return made;
}

}  // namespace

ProcessOrErrors makeFromFieldFile(const std::string& file, core::FileProvider& files, core::Compatibility compatibility,
                                  std::vector<Diagnostic>& warnings) {
  return makeFromFile(file, files, compatibility, false, warnings);
}

}  // namespace espalier::environment
