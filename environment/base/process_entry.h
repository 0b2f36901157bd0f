#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/turtle/environment_process.h"
#include "environment/base/configuration.h"
#include "environment/base/published_keyword.h"

namespace espalier::environment {

/// A process, or everything that is wrong with the request for it.
using ProcessOrErrors = tl::expected<std::unique_ptr<turtle::EnvironmentProcess>, std::vector<core::Diagnostic>>;

/// Everything the registry knows about one process. Each process defines one, named in processes.def.
struct ProcessEntry {
  std::string_view name;
  std::string_view summary;  // one sentence
  std::string_view source;   // where the model was published
  std::span<const std::string_view> aliases{};
  std::span<const ConfigurationKey> keys{};
  std::span<const PublishedKeyword> publishedKeywords{};  // of the published program's specification file
  ProcessOrErrors (*make)(const Configuration& configuration) = nullptr;
  /// The values that the published program assumes, where they differ from the defaults of `keys`. They hold for
  /// specification files, and with the key `compatible`. May be null.
  ConfigurationValues (*publishedDefaults)() = nullptr;
};

/// A ProcessOrErrors with one error: "environment process 'wind': MESSAGE".
[[nodiscard]] inline tl::unexpected<std::vector<core::Diagnostic>> refuse(std::string_view process,
                                                                          const std::string& message,
                                                                          std::string hint) {
  return tl::unexpected(std::vector{wrongConfiguration(process, message, std::move(hint))});
}

}  // namespace espalier::environment
