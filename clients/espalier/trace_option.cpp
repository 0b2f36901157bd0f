#include "clients/espalier/trace_option.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "clients/espalier/messages.h"

namespace espalier::command {

void TraceOption::addTo(CLI::App& command) {
  command.add_option("--trace", fileName_,
                     "Record all queries and replies in this file for `espalier replay` (.zst: compressed)");
}

bool TraceOption::open(LoadedEnvironment& environment) {
  if (fileName_.empty()) {
    return true;
  }
  auto created = server::TraceFile::create(fileName_);
  if (!created) {
    printError(created.error());
    return false;
  }
  file_ = std::move(*created);
  recorder_ = std::make_shared<simulation::TraceRecorder>(*file_);
  if (environment.onFailure != nullptr) {
    *environment.onFailure = [recorder = recorder_, say = *environment.onFailure](std::uint64_t step,
                                                                                  const std::string& message) {
      recorder->fail(step, message);
      say(step, message);
    };
  }
  environment.process = simulation::record(std::move(environment.process), recorder_);
  return true;
}

void TraceOption::begin(simulation::Simulation& simulation) {
  if (recorder_ != nullptr) {
    recorder_->begin(simulation);
  }
}

void TraceOption::complete(const simulation::Simulation& simulation) {
  if (recorder_ != nullptr) {
    recorder_->complete(simulation);
  }
}

bool TraceOption::close() {
  if (file_ == nullptr) {
    return true;
  }
  const auto problem = file_->close();
  if (problem) {
    printError(*problem);
  }
  return !problem;
}

}  // namespace espalier::command
