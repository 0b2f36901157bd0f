#include <algorithm>
#include <optional>
#include <utility>

#include "environment/field_text.h"
#include "environment/multiple.h"
#include "environment/process_entry.h"
#include "environment/registry.h"
#include "environment/text_exchange.h"

namespace espalier::environment {

namespace {

using core::Diagnostic;
using core::Severity;
using core::SourceLocation;

constexpr std::string_view kFieldFileKeyword = "field communication file";

/// What an `.e` file says.
struct FieldFile {
  std::string program;        // without its folder
  std::string specification;  // file name, beside the `.e` file; empty: none
  SourceLocation executable;  // of the program's name
  TurtleFormats formats;
};

/// Where the value of a line stands.
SourceLocation valueLocation(const FieldLine& line) {
  SourceLocation location = line.location;
  const std::size_t at =
      line.value.empty() ? std::string::npos : location.lineText.find(line.value, line.keyword.size() + 1);
  if (at != std::string::npos) {
    location.column = static_cast<std::uint32_t>(at + 1);
    location.length = static_cast<std::uint32_t>(line.value.size());
  }
  return location;
}

/// Reads an `.e` file.
class FieldFileReader {
 public:
  FieldFileReader(std::vector<Diagnostic>& warnings, std::vector<Diagnostic>& errors)
      : warnings_(warnings), errors_(errors) {}

  FieldFile read(const std::string& file, std::string_view text) {
    for (const FieldLine& line : readFieldLines(file, text, FieldSyntax::Environment, warnings_)) {
      readLine(line);
    }
    if (field_.program.empty() && errors_.empty()) {
      SourceLocation location;
      location.file = file;
      location.line = 1;
      location.column = 1;
      errors_.push_back(
          {Severity::Error, "the environment file names no program", location,
           "expected a line like 'executable: honda81 -e " + file.substr(file.rfind('/') + 1) + " honda.spec'"});
    }
    return std::move(field_);
  }

 private:
  void readLine(const FieldLine& line) {
    static const std::vector<std::string_view> kKeywords{
        "executable",       "communication type",  "turtle position",   "turtle heading",
        "turtle left",      "turtle up",           "turtle line width", "turtle scale factor",
        "following module", "interpreted modules", "when interpret",    "verbose",
        "remote host",      "strings only",        "binary data"};
    const std::string& keyword = line.keyword;
    if (keyword == "executable") {
      readExecutable(line);
    } else if (keyword == "turtle position") {
      field_.formats.position = readFormat(line, 3);
    } else if (keyword == "turtle heading") {
      field_.formats.heading = readFormat(line, 3);
    } else if (keyword == "turtle left") {
      field_.formats.left = readFormat(line, 3);
    } else if (keyword == "turtle up") {
      field_.formats.up = readFormat(line, 3);
    } else if (keyword == "turtle line width") {
      field_.formats.width = readFormat(line, 1);
    } else if (keyword == "turtle scale factor") {
      field_.formats.scale = readFormat(line, 1);
    } else if (keyword == "following module") {
      field_.formats.isFollowingSent = line.value != "no";
      if (line.value != "no" && line.value != "yes") {
        warn(valueLocation(line), "'following module' is neither yes nor no: taken as yes", "write yes or no");
      }
    } else if (keyword == "interpreted modules" || keyword == "when interpret") {
      warn(line.location, "'" + keyword + "' is not used: no geometry is sent with a query", {});
    } else if (keyword == "remote host") {
      warn(line.location, "'remote host' is not used: the process runs inside Espalier",
           "an environment in another process is named as tcp://HOST:PORT or stdio:COMMAND");
    } else if (std::find(kKeywords.begin(), kKeywords.end(), keyword) == kKeywords.end()) {
      warn(line.location, "unknown keyword '" + keyword + "' is ignored", core::suggestName(keyword, kKeywords));
    }
    // the rest chooses how two programs talk: communication type, verbose, strings only, binary data
  }

  void readExecutable(const FieldLine& line) {
    const std::vector<std::string> words = readFieldWords(line.value);
    if (words.empty()) {
      errors_.push_back({Severity::Error, "'executable' names no program", line.location,
                         "expected a line like 'executable: honda81 -e model.e model.spec'"});
      return;
    }
    std::string program = words[0].substr(words[0].find_last_of("/\\") + 1);
    if (program.size() > 4 && program.compare(program.size() - 4, 4, ".exe") == 0) {
      program.resize(program.size() - 4);
    }
    field_.program = program;
    field_.executable = valueLocation(line);
    field_.executable.length = static_cast<std::uint32_t>(words[0].size());
    field_.specification.clear();
    for (std::size_t i = 1; i < words.size(); ++i) {
      static const std::vector<std::string_view> kOptions{"-e", "-k", "-ext", "-host", "-C"};
      if (std::find(kOptions.begin(), kOptions.end(), words[i]) != kOptions.end()) {
        ++i;  // its value
      } else if (words[i].front() == '-') {
        warn(field_.executable, "option '" + words[i] + "' of the program is ignored", {});
      } else if (field_.specification.empty()) {
        field_.specification = words[i];
      } else {
        warn(field_.executable, "argument '" + words[i] + "' of the program is ignored",
             "one specification file is read: " + field_.specification);
      }
    }
  }

  std::optional<TurtleFormat> readFormat(const FieldLine& line, std::size_t count) {
    auto format = TurtleFormat::parse(line.value, count);
    if (const auto* reason = std::get_if<std::string>(&format)) {
      errors_.push_back({Severity::Error, "'" + line.keyword + "': " + *reason, valueLocation(line), {}});
      return std::nullopt;
    }
    const auto& read = std::get<TurtleFormat>(format);
    if (read.conversionCount() < count) {
      warn(valueLocation(line),
           "'" + line.keyword + "' sends " + std::to_string(read.conversionCount()) + " of " + std::to_string(count) +
               " numbers: the others arrive as 0",
           {});
    }
    return read;
  }

  void warn(const SourceLocation& location, std::string message, std::string hint) {
    warnings_.push_back({Severity::Warning, std::move(message), location, std::move(hint)});
  }

  std::vector<Diagnostic>& warnings_;
  std::vector<Diagnostic>& errors_;
  FieldFile field_;
};

/// A specification file as a configuration, and where each key was written.
struct Specification {
  ConfigurationValues values;
  std::map<std::string, SourceLocation> locations;  // by key
};

class SpecificationReader {
 public:
  SpecificationReader(const ProcessEntry& process, std::vector<Diagnostic>& warnings, std::vector<Diagnostic>& errors)
      : process_(process), warnings_(warnings), errors_(errors) {}

  Specification read(const std::string& file, std::string_view text) {
    for (const FieldLine& line : readFieldLines(file, text, FieldSyntax::Specification, warnings_)) {
      const auto keyword = std::find_if(process_.fieldKeywords.begin(), process_.fieldKeywords.end(),
                                        [&](const FieldKeyword& k) { return k.keyword == line.keyword; });
      if (keyword == process_.fieldKeywords.end()) {
        warnUnknown(line);
      } else {
        readLine(line, *keyword);
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

  void readLine(const FieldLine& line, const FieldKeyword& keyword) {
    if (keyword.kind == FieldKind::Unused) {
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

  void warn(const SourceLocation& location, std::string message, std::string hint) {
    warnings_.push_back({Severity::Warning, std::move(message), location, std::move(hint)});
  }

  const ProcessEntry& process_;
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
  return process.make(std::get<Configuration>(configuration));
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
  const FieldFile field = FieldFileReader(warnings, errors).read(file, *text);
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
    Specification specification = SpecificationReader(*process, warnings, errors).read(name, content);
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
