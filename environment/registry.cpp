#include "environment/registry.h"

#include <algorithm>
#include <array>
#include <utility>

#include "environment/tick_rule.h"

namespace espalier::environment {

#define ESPALIER_PROCESS(entry) extern const ProcessEntry entry;
#include "environment/processes.def"
#undef ESPALIER_PROCESS

namespace {

constexpr std::array kProcesses{
#define ESPALIER_PROCESS(entry) &entry,
#include "environment/processes.def"
#undef ESPALIER_PROCESS
};

/// The keys of a process, with the key that all have.
std::vector<ConfigurationKey> allKeysOf(const ProcessEntry& entry) {
  std::vector<ConfigurationKey> keys(entry.keys.begin(), entry.keys.end());
  keys.push_back(kTickKey);
  return keys;
}

}  // namespace

const ProcessEntry* findProcess(std::string_view name) {
  for (const ProcessEntry* entry : kProcesses) {
    if (entry->name == name || std::find(entry->aliases.begin(), entry->aliases.end(), name) != entry->aliases.end()) {
      return entry;
    }
  }
  return nullptr;
}

core::Diagnostic unknownProcess(std::string_view name) {
  std::vector<std::string_view> names;
  for (const ProcessEntry* entry : kProcesses) {
    names.push_back(entry->name);
  }
  core::Diagnostic diagnostic;
  diagnostic.message = "environment process '" + std::string(name) + "' is unknown. " + core::suggestName(name, names);
  return diagnostic;
}

std::vector<std::string> processNames() {
  std::vector<std::string> names;
  for (const ProcessEntry* entry : kProcesses) {
    names.emplace_back(entry->name);
  }
  return names;
}

std::string canonicalName(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return std::string(entry == nullptr ? name : entry->name);
}

std::vector<std::string> aliasesOf(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return entry == nullptr ? std::vector<std::string>()
                          : std::vector<std::string>(entry->aliases.begin(), entry->aliases.end());
}

std::string sourceOf(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return std::string(entry == nullptr ? std::string_view() : entry->source);
}

std::string configurationSchema(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return entry == nullptr ? std::string() : writeSchema(entry->name, entry->summary, allKeysOf(*entry));
}

ProcessOrErrors makeProcess(std::string_view name, std::string_view configurationJson) {
  const ProcessEntry* entry = findProcess(name);
  if (entry == nullptr) {
    return tl::unexpected(std::vector{unknownProcess(name)});
  }
  const std::vector<ConfigurationKey> keys = allKeysOf(*entry);
  auto configuration = readConfiguration(entry->name, keys, configurationJson);
  if (!configuration) {
    std::vector<core::Diagnostic> diagnostics;
    for (ConfigurationError& error : configuration.error()) {
      diagnostics.push_back(std::move(error.diagnostic));
    }
    return tl::unexpected(std::move(diagnostics));
  }
  if (entry->publishedDefaults != nullptr && configuration->flag("compatible")) {
    configuration->setDefaults(entry->publishedDefaults());
  }
  auto made = entry->make(*configuration);
  if (made && configuration->text(kTickKey.name) == "queries") {
    return tickingWithQueries(std::move(*made));
  }
  return made;
}

}  // namespace espalier::environment
