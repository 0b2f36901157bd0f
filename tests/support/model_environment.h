#pragma once

#include <memory>
#include <string>

#include "engine/core/streams.h"
#include "engine/turtle/environment_process.h"

namespace espalier::test {

/// Name of the environment file that `espalier run MODEL.l` uses: the `.e` file beside the model, else the `.json`
/// file; empty when there is neither.
std::string environmentFileBeside(const std::string& model, core::FileProvider& files);

/// The environment that `espalier run MODEL.l` attaches, made of built-in processes; null for a model without one.
/// Throws std::runtime_error with the first message when it cannot be made.
std::unique_ptr<turtle::EnvironmentProcess> environmentBeside(const std::string& model, core::FileProvider& files);

}  // namespace espalier::test
