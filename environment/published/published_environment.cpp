#include "environment/published/published_environment.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "environment/base/published_text.h"
#include "environment/multiple.h"
#include "environment/published/environment_file.h"
#include "environment/published/specification_file.h"
#include "environment/published/text_coupling.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

using core::Diagnostic;
using core::Severity;
using core::SourceLocation;

constexpr std::string_view kEnvironmentFileKeyword = "field communication file";

/// Sets the keys that make a process behave as the published program, if it has them.
void makeCompatible(const ProcessEntry& process, ConfigurationValues& values) {
  for (const ConfigurationKey& key : process.keys) {
    if (key.name == "compatible") {
      values.insert_or_assign("compatible", true);
    } else if (key.name == "order") {
      values.insert_or_assign("order", std::string("published"));
    }
  }
}

/// One error with its place.
tl::unexpected<std::vector<Diagnostic>> failAt(const SourceLocation& location, std::string message, std::string hint) {
  return tl::unexpected(std::vector<Diagnostic>{{Severity::Error, std::move(message), location, std::move(hint)}});
}

/// Makes the process of one `.e` file; `isMember`: another `.e` file of `multiple` names it.
ProcessOrErrors makeFromFile(const std::string& file, core::FileProvider& files, core::Compatibility compatibility,
                             bool isMember, std::vector<Diagnostic>& warnings);

/// The process `multiple` with the environments that its specification names, in order.
ProcessOrErrors makeMembers(const std::string& file, std::string_view text, core::FileProvider& files,
                            core::Compatibility compatibility, std::vector<Diagnostic>& warnings) {
  std::vector<std::unique_ptr<turtle::EnvironmentProcess>> members;
  std::vector<Diagnostic> errors;
  for (const PublishedLine& line : readPublishedLines(file, text, warnings)) {
    if (line.keyword == "verbose") {
      continue;
    }
    if (line.keyword != kEnvironmentFileKeyword) {
      warnings.push_back({Severity::Warning, "unknown keyword '" + line.keyword + "' of 'multiple' is ignored",
                          line.location, core::suggestName(line.keyword, {kEnvironmentFileKeyword})});
      continue;
    }
    auto member = makeFromFile(besideFile(file, line.value), files, compatibility, true, warnings);
    if (member) {
      members.push_back(std::move(*member));
      continue;
    }
    for (Diagnostic& error : member.error()) {
      if (error.location.file.empty()) {
        error.location = valueLocation(line);
      }
      errors.push_back(std::move(error));
    }
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  if (members.empty()) {
    SourceLocation location;
    location.file = file;
    location.line = 1;
    location.column = 1;
    return failAt(location, "the specification of 'multiple' names no environment",
                  "expected lines like 'field communication file: light.e'");
  }
  return makeMultiple(std::move(members), compatibility != core::Compatibility::Espalier);
}

/// Checks a specification like any configuration; errors point at its lines.
ProcessOrErrors makeFromSpecification(const ProcessEntry& process, const Specification& specification,
                                      const SourceLocation& executable, std::vector<Diagnostic> errors) {
  auto configuration = readConfiguration(process.name, process.keys, writeConfiguration(specification.values));
  if (!configuration) {
    for (ConfigurationError& error : configuration.error()) {
      const auto location = specification.locations.find(error.key);
      error.diagnostic.location = location == specification.locations.end() ? executable : location->second;
      errors.push_back(std::move(error.diagnostic));
    }
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return process.make(*configuration).map_error([&](std::vector<Diagnostic> problems) {
    // an error about several keys together: at the line of the first key that it names
    for (Diagnostic& problem : problems) {
      problem.location = executable;
      std::size_t first = std::string::npos;
      for (const auto& [key, location] : specification.locations) {
        const std::size_t at = problem.message.find("'" + key);
        if (at < first) {
          first = at;
          problem.location = location;
        }
      }
    }
    return problems;
  });
}

ProcessOrErrors makeFromFile(const std::string& file, core::FileProvider& files, core::Compatibility compatibility,
                             bool isMember, std::vector<Diagnostic>& warnings) {
  const auto text = files.read(file);
  if (!text) {
    return failAt({}, "cannot read the environment file '" + file + "'",
                  "check the name and that the file can be read");
  }
  std::vector<Diagnostic> errors;
  const EnvironmentFile environment = readEnvironmentFile(file, *text, warnings, errors);
  if (environment.program.empty() && errors.empty()) {
    errors.push_back(missingProgram(file));
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  const ProcessEntry* process = findProcess(environment.program);
  if (process == nullptr) {
    Diagnostic diagnostic = unknownProcess(environment.program);
    diagnostic.location = environment.executable;
    return tl::unexpected(std::vector{std::move(diagnostic)});
  }
  warnings.insert(warnings.end(), environment.ignoredArguments.begin(), environment.ignoredArguments.end());
  const bool isMultiple = process == &kMultipleProcess;
  if (isMultiple && isMember) {
    return failAt(environment.executable, "an environment of 'multiple' cannot be 'multiple' itself",
                  "name its environments in the first specification");
  }

  // the specification
  std::string name;
  std::string content;
  if (!environment.specification.empty()) {
    name = besideFile(file, environment.specification);
    const auto read = files.read(name);
    if (!read) {
      return failAt(environment.executable, "cannot read the specification file '" + name + "'",
                    "put it beside the environment file");
    }
    content = *read;
  }
  const bool isCompatible = compatibility != core::Compatibility::Espalier;
  ProcessOrErrors made;
  if (isMultiple) {
    made = makeMembers(name.empty() ? file : name, content, files, compatibility, warnings);
  } else {
    Specification specification = readSpecification(*process, name, content, files, warnings, errors);
    if (isCompatible) {
      makeCompatible(*process, specification.values);
    }
    made = makeFromSpecification(*process, specification, environment.executable, std::move(errors));
  }
  if (made && isCompatible) {
    return makeTextCoupling(std::move(*made), environment.formats);
  }
  return made;
}

/// As many of each severity as a list keeps.
std::vector<Diagnostic> withinLimit(std::vector<Diagnostic> diagnostics) {
  core::DiagnosticList list;
  for (Diagnostic& diagnostic : diagnostics) {
    list.add(std::move(diagnostic));
  }
  return list.entries();
}

}  // namespace

ProcessOrErrors makeFromEnvironmentFile(const std::string& file, core::FileProvider& files,
                                        core::Compatibility compatibility, std::vector<Diagnostic>& warnings) {
  std::vector<Diagnostic> all;
  ProcessOrErrors made = makeFromFile(file, files, compatibility, false, all);
  std::ranges::move(withinLimit(std::move(all)), std::back_inserter(warnings));
  return std::move(made).map_error(withinLimit);
}

}  // namespace espalier::environment
