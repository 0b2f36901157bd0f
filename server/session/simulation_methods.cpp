#include "server/session/simulation_methods.h"

#include <chrono>

#include "engine/language/checks/model_queries.h"
#include "protocol/base64.h"
#include "protocol/codec.h"
#include "server/remote/translation/translate.h"
#include "server/server_core.h"
#include "server/session/gallery_forest.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using protocol::ErrorCode;

// of a trace in an answer; base64 makes a third more of it
constexpr std::uint64_t kMostTraceBytes = 40'000'000;

/// A command of one turn that returns the result's JSON or an error.
std::shared_ptr<Command> makeCommand(
    SessionPointer session, const protocol::MessageId& id,
    std::function<std::variant<std::string, protocol::Error>(SimulationRunner&)> work) {
  auto command = std::make_shared<Command>();
  command->owner = session->id();
  std::weak_ptr<Session> weak = session;
  command->advance = [weak, id, work = std::move(work)](SimulationRunner& runner, Command& self) {
    const auto owner = weak.lock();
    if (owner == nullptr) {
      return false;
    }
    const auto outcome = work(runner);
    runner.publishEndOf(self);
    if (const auto* error = std::get_if<protocol::Error>(&outcome)) {
      owner->respondError(id, *error);
    } else {
      owner->respond(id, std::get<std::string>(outcome));
    }
    return false;
  };
  command->fail = [weak, id](const protocol::Error& error) {
    if (const auto self = weak.lock()) {
      self->respondError(id, error);
    }
  };
  return command;
}

protocol::Error cancelledError(std::uint64_t step) {
  protocol::JsonWriter data;
  data.beginObject().key("step").integer(step).endObject();
  return {ErrorCode::Cancelled, "Cancelled; the simulation stays at step " + std::to_string(step) + ".", data.take()};
}

/// A call that computed too long. `outcome` says how things are now, `step` is the last completed one.
protocol::Error callSecondsError(std::uint64_t bound, const std::string& outcome, std::optional<std::uint64_t> step) {
  protocol::JsonWriter data;
  data.beginObject().key("limit").text("callSeconds").key("value").integer(bound + 1).key("bound").integer(bound);
  if (step) {
    data.key("step").integer(*step);
  }
  return {ErrorCode::Limit,
          "callSeconds is limited to " + std::to_string(bound) + ", and this has computed longer. " + outcome +
              " Use a smaller model, or start the server with a higher --limit callSeconds=N.",
          data.endObject().take()};
}

/// The seed that a run uses: the caller's, else the model's, else one drawn now.
std::uint64_t effectiveSeed(const protocol::CreateParams& params, const simulation::Programs& programs) {
  if (params.seed) {
    return *params.seed;
  }
  for (const auto& program : programs) {
    const auto& model = program->systems.empty() ? std::optional<std::int64_t>() : program->systems.front().seed;
    if (model && *model >= 0) {
      return static_cast<std::uint64_t>(*model);
    }
  }
  return drawSeed();
}

/// The models of a simulation, compiled.
struct CompiledModels {
  simulation::Programs programs;
  std::vector<core::Diagnostic> diagnostics;
  std::string environmentJson;  // that a gallery model brings; empty: none
};

std::variant<CompiledModels, protocol::Error> compileModels(ServerCore& core, const protocol::CreateParams& params) {
  std::vector<protocol::ModelParams> models;
  for (const protocol::NamedModel& model : params.models) {
    models.push_back(model.model);
  }
  if (models.empty()) {
    models.push_back(params.model);
  }
  CompiledModels result;
  for (const protocol::ModelParams& model : models) {
    auto compiled = core.models().compile(model, core.options().limits.simulation);
    if (auto* error = std::get_if<protocol::Error>(&compiled)) {
      return std::move(*error);
    }
    auto& made = std::get<CompiledModel>(compiled);
    const auto& entries = made.result.diagnostics.entries();
    if (made.result.program == nullptr) {
      return toError(entries);
    }
    if (!result.programs.empty() && made.result.program->compatibility != result.programs.front()->compatibility) {
      return protocol::fieldError("params.models", "all models must have the same \"compatibility\"");
    }
    result.programs.push_back(made.result.program);
    result.diagnostics.insert(result.diagnostics.end(), entries.begin(), entries.end());
    if (result.environmentJson.empty()) {
      result.environmentJson = std::move(made.environmentJson);
    }
  }
  return result;
}

/// A step command's state between turns.
struct StepProgress {
  protocol::StepParams params;
  std::uint64_t madeSteps = 0;
  std::uint64_t queries = 0;
  std::uint64_t answers = 0;
  double milliseconds = 0.0;
  std::chrono::steady_clock::time_point told{};  // when the caller last heard how far it is
};

// how often a caller hears of its progress, and how full its outbox may be for it
constexpr std::chrono::milliseconds kProgressInterval{100};
constexpr std::size_t kProgressOutbox = 1'000'000;

/// Says how far a call is, when the caller asked for it.
void tellProgress(SimulationRunner& runner, Session& session, const protocol::MessageId& id, StepProgress& progress) {
  const auto now = std::chrono::steady_clock::now();
  if (!progress.params.wantsProgress || now - progress.told < kProgressInterval ||
      session.outboxBytes() > kProgressOutbox) {
    return;
  }
  progress.told = now;
  simulation::Simulation& simulation = runner.hosted().simulation();
  protocol::JsonWriter params;
  params.beginObject().key("id").raw(protocol::toText(id)).key("step").integer(simulation.completedSteps());
  params.key("made").integer(progress.madeSteps).key("modules").integer(simulation.statistics().modules);
  session.notify("$/progress", params.endObject().take());
}

protocol::StepResult resultOf(SimulationRunner& runner, const StepProgress& progress, bool isTruncated) {
  simulation::Simulation& simulation = runner.hosted().simulation();
  protocol::StepResult result;
  result.step = simulation.completedSteps();
  result.isFinished = simulation.isFinished();
  result.isTruncated = isTruncated;
  result.isSaved = runner.hosted().isSaved();
  result.statistics = toStatistics(simulation.statistics(), progress.milliseconds);
  if (progress.madeSteps > 0) {
    result.statistics.queries = progress.queries;
    result.statistics.answers = progress.answers;
  }
  return result;
}

bool isDone(const SimulationRunner&, const simulation::Simulation& simulation, const StepProgress& progress) {
  return simulation.isFinished() || (progress.params.until ? simulation.completedSteps() >= *progress.params.until
                                                           : progress.madeSteps >= progress.params.steps);
}

/// One turn: one step. Returns whether there is more to do.
bool advanceSteps(SimulationRunner& runner, Command& command, Session& session, const protocol::MessageId& id,
                  StepProgress& progress) {
  simulation::Simulation& simulation = runner.hosted().simulation();
  if (command.isCancelled) {
    runner.publishEndOf(command);
    session.respondError(id, cancelledError(simulation.completedSteps()));
    return false;
  }
  const bool isAtEnd = isDone(runner, simulation, progress);
  if (isAtEnd || command.isPaused) {
    runner.publishEndOf(command);
    session.respond(id, protocol::encode(resultOf(runner, progress, !isAtEnd)));
    return false;
  }
  double milliseconds = 0.0;
  const std::uint64_t before = simulation.completedSteps();
  const auto error = runner.hosted().step(milliseconds);
  const bool isMade = simulation.completedSteps() > before;
  if (isMade) {
    const simulation::StepStatistics& statistics = simulation.statistics();
    ++progress.madeSteps;
    progress.queries += statistics.queries;
    progress.answers += statistics.answers;
    progress.milliseconds += milliseconds;
    runner.setMilliseconds(milliseconds);
  }
  if (error && command.isCancelled) {
    runner.setLastError({});
    runner.publishEndOf(command);
    session.respondError(id, cancelledError(simulation.completedSteps()));
    return false;
  }
  if (error) {
    const std::uint64_t stays = simulation.completedSteps();
    const protocol::Error reason =
        command.isOverLimit ? callSecondsError(runner.callSeconds(),
                                               "The simulation stays at step " + std::to_string(stays) + ".", stays)
                            : *error;
    runner.setLastError(reason.message);
    runner.publishEndOf(command);
    session.respondError(id, reason);
    if (isMade) {
      runner.publishFrames(true);
    }
    return false;
  }
  runner.setLastError({});
  const bool isLast = isDone(runner, simulation, progress);
  if (isLast || runner.isClosing()) {
    // the controller first, viewers after
    runner.publishEndOf(command);
    session.respond(id, protocol::encode(resultOf(runner, progress, !isLast)));
    runner.publishFrames(true);
    return false;
  }
  runner.publishFrames(true);
  tellProgress(runner, session, id, progress);
  return true;
}

std::variant<std::string, protocol::Error> getResult(SimulationRunner& runner, const protocol::GetParams& params) {
  HostedSimulation& hosted = runner.hosted();
  simulation::Simulation& simulation = hosted.simulation();
  if (params.plant >= simulation.plantCount()) {
    return protocol::fieldError("params.plant", "there is no plant " + std::to_string(params.plant) +
                                                    "; this simulation has " + std::to_string(simulation.plantCount()) +
                                                    ", numbered from 0");
  }
  protocol::JsonWriter result;
  result.beginObject().key("step").integer(simulation.completedSteps());
  if (params.what == "string") {
    result.key("string").text(simulation.stringText(params.plant));
  } else if (params.what == "statistics") {
    write(result, toStatistics(simulation.statistics(), runner.milliseconds()));
    result.key("finished").boolean(simulation.isFinished());
  } else if (params.what == "state-hash") {
    // 64 bits do not fit a JSON number
    constexpr std::string_view kDigits = "0123456789abcdef";
    const std::uint64_t hash = simulation.stateHash();
    std::string text;
    for (unsigned shift = 64; shift > 0; shift -= 4) {
      text += kDigits[(hash >> (shift - 4U)) & 15U];
    }
    result.key("stateHash").text(text);
  } else if (params.what == "model") {
    const language::Program& program = simulation.program();
    result.key("model").beginObject().key("main").text(program.modelFile).key("files").beginObject();
    std::string files;
    for (const auto& file : program.sources) {
      protocol::JsonWriter name;
      protocol::JsonWriter text;
      files += (files.empty() ? "" : ",") + name.text(file.name).take() + ":" + text.text(file.text).take();
    }
    if (!files.empty()) {
      result.raw(files);
    }
    result.endObject().endObject();
  } else if (params.what == "checkpoints") {
    result.key("checkpoints").beginArray();
    for (const Store::Checkpoint& checkpoint : hosted.checkpoints()) {
      result.beginObject().key("checkpoint").text(checkpoint.name).key("step").integer(checkpoint.step);
      result.key("bytes").integer(checkpoint.bytes).endObject();
    }
    result.endArray();
  } else if (params.what == "traces") {
    result.key("traces").beginArray();
    for (const StoredTrace& trace : hosted.traces()) {
      result.beginObject().key("trace").integer(trace.number).key("bytes").integer(trace.bytes).endObject();
    }
    result.endArray();
  } else if (params.what == "trace") {
    const auto trace = hosted.readTrace(params.trace, kMostTraceBytes);
    if (!trace) {
      return protocol::fieldError("params.trace", "there is no trace " + std::to_string(params.trace) +
                                                      " of this simulation, or it is too large for an answer; ask for "
                                                      "its traces, or download it over HTTP");
    }
    result.key("trace").integer(params.trace).key("content").text(protocol::toBase64(*trace));
  } else if (params.what == "turtle") {
    protocol::StreamOpenParams all;
    all.what = "turtle";
    all.select = params.select;
    auto frame = FrameMaker(simulation, 0.0, nullptr).make(all, {});
    if (const auto* error = std::get_if<core::SimulationError>(&frame)) {
      return hosted.errorOf(*error);
    }
    result.raw(std::get<StreamFrame>(frame).body.json);
  } else {
    result.key("information");
    write(result, runner.information());
  }
  return result.endObject().take();
}

protocol::CreateResult createResultOf(HostedSimulation& hosted) {
  protocol::CreateResult result;
  result.simulation = hosted.record().id;
  result.step = hosted.simulation().completedSteps();
  result.seed = hosted.record().seed;
  result.derivationLength = hosted.simulation().derivationLength();
  result.plants = static_cast<std::uint32_t>(hosted.simulation().plantCount());
  result.isFinished = hosted.simulation().isFinished();
  result.statistics = toStatistics(hosted.simulation().statistics(), 0.0);
  return result;
}

std::variant<std::string, protocol::Error> forkSimulation(ServerCore& core, HostedSimulation& original,
                                                          const std::string& session, const std::string& title) {
  auto reserved = core.reserve(session);
  if (auto* error = std::get_if<protocol::Error>(&reserved)) {
    return std::move(*error);
  }
  const std::string& name = std::get<std::string>(reserved);
  SimulationRecord record = original.record();
  record.id = name;
  if (!title.empty()) {
    record.create.name = title;
  }
  std::variant<std::unique_ptr<HostedSimulation>, protocol::Error> made = protocol::Error{};
  try {
    made = HostedSimulation::fork(std::move(record), original, core.options().limits.simulation,
                                  core.environmentServices(), core.store());
  } catch (...) {
    core.remove(name);
    throw;
  }
  if (auto* error = std::get_if<protocol::Error>(&made)) {
    core.remove(name);
    return std::move(*error);
  }
  auto& hosted = std::get<std::unique_ptr<HostedSimulation>>(made);
  const std::string result = protocol::encode(createResultOf(*hosted));
  core.add(name, std::move(hosted));
  return result;
}

std::string stateAfter(SimulationRunner& runner) {
  protocol::JsonWriter result;
  result.beginObject().key("step").integer(runner.hosted().simulation().completedSteps());
  result.key("seed").integer(runner.hosted().record().seed);
  result.key("finished").boolean(runner.hosted().simulation().isFinished());
  return result.endObject().take();
}

/// What the text of a model alone does not show: queries that nobody answers, files that a server does not write.
std::vector<core::Diagnostic> warningsOfRun(const language::Program& program, const HostedSimulation& hosted) {
  std::vector<core::Diagnostic> warnings = language::unwrittenFiles(program);
  // a single environment takes all queries, whatever they are called
  if (hosted.processNames().size() != 1) {
    for (core::Diagnostic& warning : language::unansweredQueries(program, hosted.processNames())) {
      warnings.push_back(std::move(warning));
    }
  }
  return warnings;
}

/// The answer to a change between steps, and a frame of it for the viewers.
std::variant<std::string, protocol::Error> changed(SimulationRunner& runner, std::optional<protocol::Error> error) {
  if (error) {
    return std::move(*error);
  }
  runner.setLastError({});
  runner.publishFrames(true);
  return stateAfter(runner);
}

}  // namespace

void createSimulation(Session& session, const protocol::MessageId& id, protocol::CreateParams params,
                      Interruption& interruption) {
  ServerCore& core = session.core();
  if (const auto problem = expandGalleryForest(core.options().galleryFolder, params)) {
    session.respondError(id, *problem);
    return;
  }
  auto compiled = compileModels(core, params);
  if (const auto* error = std::get_if<protocol::Error>(&compiled)) {
    session.respondError(id, *error);
    return;
  }
  const auto& models = std::get<CompiledModels>(compiled);
  const auto reserved = core.reserve(session.id());
  if (const auto* error = std::get_if<protocol::Error>(&reserved)) {
    session.respondError(id, *error);
    return;
  }
  const std::string& name = std::get<std::string>(reserved);

  // the record is what makes the simulation again after a restart
  SimulationRecord record;
  record.id = name;
  record.seed = effectiveSeed(params, models.programs);
  record.hasSeed = params.seed.has_value();
  record.create = std::move(params);
  if (record.create.name.empty()) {
    record.create.name = record.create.model.model.gallery.value_or(models.programs.front()->modelFile);
  }
  record.create.model = {};
  for (protocol::NamedModel& model : record.create.models) {
    model.model = {};
  }
  if (record.create.environmentJson.empty()) {
    record.create.environmentJson = models.environmentJson;
  }
  std::variant<std::unique_ptr<HostedSimulation>, protocol::Error> made = protocol::Error{};
  try {
    made = HostedSimulation::create(std::move(record), models.programs, core.options().limits.simulation,
                                    core.environmentServices(), core.store(), interruption);
  } catch (...) {
    core.remove(name);
    throw;
  }
  if (const auto* error = std::get_if<protocol::Error>(&made)) {
    core.remove(name);
    switch (interruption.reason()) {
      case Interruption::Reason::None:
        session.respondError(id, *error);
        break;
      case Interruption::Reason::Cancelled:
        session.respondError(id, {ErrorCode::Cancelled, "Cancelled; nothing was created.", {}});
        break;
      case Interruption::Reason::CallSeconds:
        session.respondError(id, callSecondsError(core.options().limits.callSeconds, "Nothing was created.", {}));
        break;
    }
    return;
  }
  auto& hosted = std::get<std::unique_ptr<HostedSimulation>>(made);
  protocol::CreateResult result = createResultOf(*hosted);
  result.diagnostics = toRecords(models.diagnostics);
  for (const auto& program : models.programs) {
    for (protocol::DiagnosticRecord& warning : toRecords(warningsOfRun(*program, *hosted))) {
      result.diagnostics.push_back(std::move(warning));
    }
  }
  core.add(name, std::move(hosted));
  core.log().info("created", {.session = session.id(), .simulation = name});
  session.respond(id, protocol::encode(result));
}

std::shared_ptr<Command> makeStepCommand(SessionPointer session, const protocol::MessageId& id,
                                         protocol::StepParams params) {
  auto command = std::make_shared<Command>();
  command->lane = Lane::Step;
  command->owner = session->id();
  const auto progress = std::make_shared<StepProgress>();
  progress->params = std::move(params);
  std::weak_ptr<Session> weak = session;
  command->advance = [weak, id, progress](SimulationRunner& runner, Command& self) {
    const auto owner = weak.lock();
    return owner != nullptr && advanceSteps(runner, self, *owner, id, *progress);
  };
  command->fail = [weak, id](const protocol::Error& error) {
    if (const auto owner = weak.lock()) {
      owner->respondError(id, error);
    }
  };
  return command;
}

std::shared_ptr<Command> makePauseCommand(SessionPointer session, const protocol::MessageId& id, protocol::NameParams) {
  return makeCommand(std::move(session), id,
                     [](SimulationRunner& runner) -> std::variant<std::string, protocol::Error> {
                       const std::size_t paused = runner.pauseWaiting();
                       protocol::JsonWriter result;
                       result.beginObject().key("step").integer(runner.hosted().simulation().completedSteps());
                       return result.key("paused").integer(std::uint64_t{paused}).endObject().take();
                     });
}

std::shared_ptr<Command> makeSetCommand(SessionPointer session, const protocol::MessageId& id,
                                        protocol::SetParams params) {
  return makeCommand(std::move(session), id, [params = std::move(params)](SimulationRunner& runner) {
    return changed(runner, runner.hosted().set(params.values));
  });
}

std::shared_ptr<Command> makeEditCommand(SessionPointer session, const protocol::MessageId& id,
                                         protocol::EditParams params) {
  return makeCommand(std::move(session), id, [params = std::move(params)](SimulationRunner& runner) {
    return changed(runner, runner.hosted().edit(params));
  });
}

std::shared_ptr<Command> makeForkCommand(SessionPointer session, const protocol::MessageId& id,
                                         protocol::ForkParams params) {
  ServerCore* const core = &session->core();
  const std::string creator = session->id();
  return makeCommand(std::move(session), id, [core, creator, name = std::move(params.name)](SimulationRunner& runner) {
    return forkSimulation(*core, runner.hosted(), creator, name);
  });
}

std::shared_ptr<Command> makeGetCommand(SessionPointer session, const protocol::MessageId& id,
                                        protocol::GetParams params) {
  return makeCommand(std::move(session), id,
                     [params = std::move(params)](SimulationRunner& runner) { return getResult(runner, params); });
}

std::shared_ptr<Command> makeResetCommand(SessionPointer session, const protocol::MessageId& id,
                                          protocol::ResetParams params) {
  return makeCommand(std::move(session), id,
                     [seed = params.seed](SimulationRunner& runner) -> std::variant<std::string, protocol::Error> {
                       return changed(runner, runner.hosted().reset(seed));
                     });
}

std::shared_ptr<Command> makeSaveCommand(SessionPointer session, const protocol::MessageId& id,
                                         protocol::SaveParams params) {
  return makeCommand(
      std::move(session), id,
      [params = std::move(params)](SimulationRunner& runner) -> std::variant<std::string, protocol::Error> {
        HostedSimulation& hosted = runner.hosted();
        if (auto error = params.checkpoint.empty() ? hosted.keep() : hosted.saveCheckpoint(params.checkpoint)) {
          return std::move(*error);
        }
        protocol::JsonWriter result;
        result.beginObject().key("step").integer(hosted.simulation().completedSteps());
        result.key("saved").boolean(hosted.isSaved());
        if (!params.checkpoint.empty()) {
          result.key("checkpoint").text(params.checkpoint);
        }
        if (params.hasSnapshot) {
          result.key("snapshot").text(protocol::toBase64(hosted.snapshot()));
        }
        return result.endObject().take();
      });
}

std::shared_ptr<Command> makeRestoreCommand(SessionPointer session, const protocol::MessageId& id,
                                            protocol::RestoreParams params) {
  return makeCommand(
      std::move(session), id,
      [params = std::move(params)](SimulationRunner& runner) -> std::variant<std::string, protocol::Error> {
        HostedSimulation& hosted = runner.hosted();
        return changed(runner, params.checkpoint.empty() ? hosted.restore(params.snapshot)
                                                         : hosted.restoreCheckpoint(params.checkpoint));
      });
}

std::shared_ptr<Command> makeTraceCommand(SessionPointer session, const protocol::MessageId& id,
                                          protocol::TraceParams params) {
  return makeCommand(
      std::move(session), id,
      [params = std::move(params)](SimulationRunner& runner) -> std::variant<std::string, protocol::Error> {
        HostedSimulation& hosted = runner.hosted();
        if (auto error = hosted.setTraced(params.isTraced)) {
          return std::move(*error);
        }
        protocol::JsonWriter result;
        result.beginObject().key("step").integer(hosted.simulation().completedSteps());
        result.key("traced").boolean(hosted.isTraced());
        return result.endObject().take();
      });
}

std::shared_ptr<Command> makeStreamOpenCommand(SessionPointer session, const protocol::MessageId& id,
                                               std::shared_ptr<Stream> stream) {
  auto command = std::make_shared<Command>();
  command->owner = session->id();
  std::weak_ptr<Session> weak = session;
  command->advance = [weak, id, stream](SimulationRunner& runner, Command& self) {
    if (const auto owner = weak.lock()) {
      runner.publishEndOf(self);
      protocol::JsonWriter result;
      result.beginObject().key("stream").text(stream->id());
      result.key("step").integer(runner.hosted().simulation().completedSteps()).endObject();
      owner->respond(id, result.view());
      runner.addStream(stream);
      runner.publishFirstFrame(*stream);
    }
    return false;
  };
  command->fail = [weak, id, stream](const protocol::Error& error) {
    if (const auto owner = weak.lock()) {
      (void)owner->closeStream(stream->id());
      owner->respondError(id, error);
    }
  };
  return command;
}

void deleteSimulation(Session& session, const protocol::MessageId& id,
                      const std::shared_ptr<SimulationRunner>& runner) {
  // after the last turn: none writes the files again, and none adds a stream
  const auto command = makeCommand(session.shared_from_this(), id,
                                   [](SimulationRunner& self) -> std::variant<std::string, protocol::Error> {
                                     self.endStreams("the simulation was deleted");
                                     if (auto error = self.hosted().removeFromDisk()) {
                                       return std::move(*error);
                                     }
                                     return std::string("{}");
                                   });
  runner->closeWith(command, {ErrorCode::NotFound, "The simulation was deleted.", {}});
}

}  // namespace espalier::server
