#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"
#include "protocol/errors.h"
#include "protocol/messages.h"
#include "server/running/environment_builder.h"
#include "server/running/interruption.h"
#include "server/running/metered_environment.h"
#include "server/running/run_messages.h"
#include "server/running/simulation_trace.h"
#include "server/store/simulation_record.h"
#include "server/store/store.h"
#include "server/stream/query_recorder.h"

namespace espalier::server {

/// A simulation of the server, with the record from which it can be made again. For one worker at a time, except where
/// a member says otherwise.
class HostedSimulation {
 public:
  /// Builds the environment, goes to step 0 and saves. `palette` has the colours of the model folders. `limits` are the
  /// server's; the record can lower them. `interruption` can end this until the simulation is saved.
  [[nodiscard]] static protocol::Expected<std::unique_ptr<HostedSimulation>> create(
      SimulationRecord record, simulation::Programs programs, files::Palette palette, const core::Limits& limits,
      const EnvironmentServices& services, Store& store, Interruption& interruption);
  /// Another simulation, by `record`, in the state of `original`, and saves it.
  [[nodiscard]] static protocol::Expected<std::unique_ptr<HostedSimulation>> fork(SimulationRecord record,
                                                                                  const HostedSimulation& original,
                                                                                  const core::Limits& limits,
                                                                                  const EnvironmentServices& services,
                                                                                  Store& store);
  /// From the data folder. Environments in other processes may be away; stepping asks for them again.
  [[nodiscard]] static protocol::Expected<std::unique_ptr<HostedSimulation>> load(SimulationRecord record,
                                                                                  std::string_view snapshot,
                                                                                  const core::Limits& limits,
                                                                                  const EnvironmentServices& services,
                                                                                  Store& store);

  [[nodiscard]] const SimulationRecord& record() const { return record_; }
  [[nodiscard]] simulation::Simulation& simulation() { return *simulation_; }
  [[nodiscard]] const std::vector<std::string>& environmentNames() const { return environmentNames_; }
  /// The names by which queries address the environments.
  [[nodiscard]] const std::vector<std::string>& processNames() const { return processNames_; }
  [[nodiscard]] bool isSaved() const { return isSaved_; }
  /// The strings, which are kept twice: a step reads one copy and writes the other. And what a step knows about them.
  [[nodiscard]] std::uint64_t stringBytes() const {
    return 2 * simulation_->statistics().bytes + simulation_->keptBytes();
  }
  [[nodiscard]] std::uint64_t environmentBytes() const {
    const std::int64_t bytes = *environmentBytes_;
    return (bytes > 0 ? static_cast<std::uint64_t>(bytes) : 0) + (trace_ == nullptr ? 0 : trace_->memoryBytes());
  }
  /// The bytes of its compiled models that no other simulation shares, and of the data that it was made from.
  [[nodiscard]] std::uint64_t modelBytes() const {
    return modelBytes_ + record_.create.name.size() + record_.create.environmentJson.size();
  }
  void setModelBytes(std::int64_t bytes) { modelBytes_ = bytes > 0 ? static_cast<std::uint64_t>(bytes) : 0; }
  /// The copy on disk is all that it needs to go on later: it is saved, its environment is in this process, and it has
  /// no trace.
  [[nodiscard]] bool canBePassive() const {
    return isSaved_ && store_->isKept() && links_.empty() && trace_ == nullptr;
  }
  /// From now on the queries of steps are kept, or not.
  void recordQueries(bool isRecorded) { queries_->want(isRecorded); }
  /// The queries of the last step that was recorded. Null: none.
  [[nodiscard]] std::shared_ptr<const QueryRecord> lastQueries() const { return queries_->last(); }
  /// A failure of this simulation for the wire.
  [[nodiscard]] protocol::Error errorOf(const core::SimulationError& error) const;

  /// One step, saved when that is due. `milliseconds` receives the wall time of the step alone. A step that could not
  /// be saved is complete all the same: an error says so, and the step is saved before the next step runs.
  [[nodiscard]] std::optional<protocol::Error> step(double& milliseconds);
  /// Back to step 0; with a new seed when given. On failure nothing changes.
  [[nodiscard]] std::optional<protocol::Error> reset(std::optional<std::uint64_t> seed);
  [[nodiscard]] std::string snapshot() const;
  /// Changes a plant's string. On failure nothing changes.
  [[nodiscard]] std::optional<protocol::Error> edit(const protocol::EditParams& params);
  /// Sets variables of the model, or names that it defines (#define). On failure nothing changes.
  [[nodiscard]] std::optional<protocol::Error> set(const std::vector<std::pair<std::string, std::string>>& values);
  /// On failure nothing changes.
  [[nodiscard]] std::optional<protocol::Error> restore(std::string_view snapshot);
  /// Writes the present state to disk, unless the simulation is not kept or is saved already.
  [[nodiscard]] std::optional<protocol::Error> keep();
  /// Keeps the present state under a name.
  [[nodiscard]] std::optional<protocol::Error> saveCheckpoint(const std::string& name);
  [[nodiscard]] std::optional<protocol::Error> restoreCheckpoint(const std::string& name);
  [[nodiscard]] std::vector<Store::Checkpoint> checkpoints() const { return store_->checkpoints(record_.id); }
  [[nodiscard]] Store::State readCheckpoint(const std::string& name) const {
    return store_->readCheckpoint(record_.id, name);
  }
  /// Begins a trace, or ends the one being written. On failure nothing changes.
  [[nodiscard]] std::optional<protocol::Error> setTraced(bool isTraced);
  [[nodiscard]] bool isTraced() const { return trace_ != nullptr && traceProblem().empty(); }
  /// Warnings of its steps that no answer has taken yet.
  [[nodiscard]] std::vector<std::string> takeWarnings() { return messages_->takeWarnings(); }
  /// What the model has printed since the last answer.
  [[nodiscard]] std::string takePrinted() { return messages_->takePrinted(); }
  /// Why the trace has ended although the simulation goes on: a sentence; empty: it has not.
  [[nodiscard]] std::string traceProblem() const { return trace_ == nullptr ? std::string() : trace_->problem(); }
  [[nodiscard]] std::vector<StoredTrace> traces() const {
    return SimulationTrace::list(services_.traces.path, record_.id);
  }
  /// The bytes of a trace so far; nothing when there is none of the number, or it is larger than `bound`.
  [[nodiscard]] std::optional<std::string> readTrace(std::uint64_t number, std::uint64_t bound) const {
    return SimulationTrace::read(services_.traces.path, record_.id, number, bound);
  }

  /// Ends the trace that is being written, before its file is removed.
  void closeTrace();
  /// Tells the environments in other processes that the simulation is no more. A silent one is waited for a second.
  void closeEnvironments();

  /// From any thread. True: the running step is given up, also while it waits for an environment. False: steps are
  /// possible again.
  void setCancelled(bool isCancelled);

 private:
  HostedSimulation(SimulationRecord record, const core::Limits& limits, const EnvironmentServices& services,
                   Store& store);
  [[nodiscard]] std::optional<protocol::Error> build(simulation::Programs programs, files::Palette palette,
                                                     bool isAbsenceTolerated);
  void beginTrace();
  /// Saves a new simulation and its record. On failure its trace leaves no file.
  [[nodiscard]] std::optional<protocol::Error> saveNew();
  [[nodiscard]] bool isKept() const { return store_->isKept() && record_.create.save.isKept; }
  /// Writes state and, when `withRecord`, record. The rest of a sentence says what failed.
  [[nodiscard]] std::optional<std::string> write(bool withRecord);
  /// The same after a step.
  [[nodiscard]] std::optional<protocol::Error> save(bool withRecord);
  [[nodiscard]] bool savesChanges() const { return isKept() && record_.create.save.every > 0; }
  /// The state to go back to when a change cannot be saved; empty when changes are not saved.
  [[nodiscard]] std::string stateBefore() const { return savesChanges() ? snapshot() : std::string(); }
  /// Makes a change that a client asked for, and saves it unless the simulation is saved on request only. When it
  /// cannot be saved, the state `before` is restored.
  [[nodiscard]] std::optional<protocol::Error> change(
      const std::string& before, const std::function<std::optional<core::SimulationError>()>& make);
  /// Saves another one that was made from the same record in the same way, and takes its parts over.
  [[nodiscard]] std::optional<protocol::Error> replaceBy(HostedSimulation& fresh, bool isRecordNew);
  void adopt(HostedSimulation& fresh);
  /// Compiles the models again with other definitions and goes on in the same state.
  [[nodiscard]] std::optional<protocol::Error> define(const std::vector<std::pair<std::string, std::string>>& defines);
  [[nodiscard]] protocol::Error storageError(const std::string& problem) const;

  SimulationRecord record_;
  core::Limits limits_;
  EnvironmentServices services_;
  Store* store_;
  std::mutex cancelMutex_;  // the next two change only with it held
  std::unique_ptr<simulation::Simulation> simulation_;
  std::vector<std::shared_ptr<EnvironmentLink>> links_;
  std::vector<std::string> environmentNames_;
  std::vector<std::string> processNames_;
  std::shared_ptr<SimulationTrace> trace_;  // null: none
  std::shared_ptr<EnvironmentBytes> environmentBytes_ = std::make_shared<EnvironmentBytes>(0);
  std::uint64_t modelBytes_ = 0;
  std::shared_ptr<QueryRecorder> queries_ = std::make_shared<QueryRecorder>();
  std::shared_ptr<RunMessages> messages_ = std::make_shared<RunMessages>();
  bool isSaved_ = false;    // the copy on disk is of the present step
  bool isSaveDue_ = false;  // it could not be written: the next step saves it first
};

}  // namespace espalier::server
