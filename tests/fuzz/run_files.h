#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/core/identifiers.h"
#include "engine/turtle/environment_process.h"

namespace espalier::fuzz {

/// The files of a run of a bundled model (bundle.h), within small limits.
struct RunFiles {
  std::string snapshot;  // after some steps
  std::string trace;     // of these steps
  std::string string;    // the first plant's string after them
};

/// Nothing: the model does not compile or does not run within the limits.
[[nodiscard]] std::optional<RunFiles> runFilesOf(std::string_view bundle,
                                                 core::Compatibility compatibility = core::Compatibility::Espalier);

/// An environment of any name that answers every query and takes any text as its state.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeAnsweringEnvironment(std::string name);

}  // namespace espalier::fuzz
