#include "server/session/methods.h"

#include <algorithm>
#include <array>
#include <new>

#include "engine/core/diagnostic.h"
#include "environment/registry.h"
#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/json_writer.h"
#include "protocol/version.h"
#include "server/remote/gallery.h"
#include "server/remote/translation/translate.h"
#include "server/server_core.h"
#include "server/session/session.h"
#include "server/session/simulation_methods.h"

namespace espalier::server {
namespace {

using protocol::ErrorCode;

/// Runs work on the pool; its exceptions become the answer. `interruption`, when given, ends it when the request is
/// cancelled, the connection lost or the time of a call over.
void runOnPool(Session& session, const protocol::MessageId& id, std::function<void(Session&)> work,
               const std::shared_ptr<Interruption>& interruption = nullptr) {
  WorkerPool::Task task;
  task.owner = session.id();
  if (interruption != nullptr) {
    session.onCancel(id, [interruption] { interruption->interrupt(Interruption::Reason::Cancelled); });
    task.limit = std::chrono::seconds(session.core().options().limits.callSeconds);
    task.onLimit = [interruption] { interruption->interrupt(Interruption::Reason::CallSeconds); };
  }
  task.run = [weak = session.weak_from_this(), id, work = std::move(work)] {
    const auto self = weak.lock();
    if (self == nullptr) {
      return;
    }
    try {
      work(*self);
    } catch (const std::bad_alloc&) {
      self->respondError(id, {ErrorCode::Limit, "The server has not enough memory for this. Use a smaller model.", {}});
    } catch (const std::exception& exception) {
      self->core().log().error(std::string("internal error: ") + exception.what(), {.session = self->id()});
      self->respondError(
          id,
          {ErrorCode::Internal, std::string("Espalier has a bug: ") + exception.what() + ". Please report it.", {}});
    }
  };
  session.core().pool().post(std::move(task));
}

// ---- models ----

void compileModel(Session& session, const protocol::Message& message, bool isKept) {
  auto decoded = protocol::decodeModelParams(message.payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  runOnPool(session, message.id,
            [id = message.id, isKept, params = std::move(std::get<protocol::ModelParams>(decoded))](Session& self) {
              auto compiled = self.core().models().compile(params, self.core().options().limits.simulation);
              if (const auto* error = std::get_if<protocol::Error>(&compiled)) {
                self.respondError(id, *error);
                return;
              }
              const auto& model = std::get<CompiledModel>(compiled);
              const auto& program = model.result.program;
              protocol::ModelResult result;
              result.isValid = program != nullptr;
              result.diagnostics = toRecords(model.result.diagnostics.entries());
              if (program != nullptr) {
                result.derivationLength = program->derivationLength;
                for (const language::Symbol& symbol : program->symbols) {
                  result.symbols.push_back(symbol.name);
                }
              }
              if (isKept) {
                if (program == nullptr) {
                  self.respondError(id, toError(model.result.diagnostics.entries()));
                  return;
                }
                auto kept = self.core().models().keep(model);
                if (const auto* error = std::get_if<protocol::Error>(&kept)) {
                  self.respondError(id, *error);
                  return;
                }
                result.model = std::get<std::string>(kept);
              }
              self.respond(id, protocol::encode(result));
            });
}

void modelCheck(Session& session, const protocol::Message& message) {
  compileModel(session, message, false);
}

void modelLoad(Session& session, const protocol::Message& message) {
  compileModel(session, message, true);
}

// ---- simulations ----

void simulationCreate(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeCreateParams(message.payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  auto& params = std::get<protocol::CreateParams>(decoded);
  const ServerOptions& options = session.core().options();
  for (std::size_t i = 0; i < params.environmentTypes.size(); ++i) {
    if (params.environmentTypes[i] == "stdio" && !session.isLocal() && !options.isSpawnAllowed) {
      session.respondError(message.id,
                           {ErrorCode::Unauthorised,
                            "params.environment[" + std::to_string(i) +
                                "]: commands are started only for callers on the server's own machine. Start "
                                "the server with --allow-spawn, or offer the environment over the network.",
                            {}});
      return;
    }
  }
  const auto interruption = std::make_shared<Interruption>();
  runOnPool(
      session, message.id,
      [id = message.id, create = std::move(params), interruption](Session& self) mutable {
        createSimulation(self, id, std::move(create), *interruption);
      },
      interruption);
}

/// The runner named in the params, or nothing after answering.
std::shared_ptr<SimulationRunner> findRunner(Session& session, const protocol::MessageId& id, const std::string& name) {
  auto runner = session.core().find(name);
  if (runner == nullptr) {
    const auto damaged = session.core().findDamaged(name);
    session.respondError(
        id, damaged ? protocol::Error{ErrorCode::Storage,
                                      "Simulation '" + name + "' could not be loaded: " + damaged->damage +
                                          " simulation.delete removes it.",
                                      {}}
                    : protocol::Error{ErrorCode::NotFound,
                                      "There is no simulation '" + name + "'. simulation.list names those there are.",
                                      {}});
  }
  return runner;
}

/// Decodes params that name a simulation, finds it and submits what `make` returns.
template <typename Params, typename Make>
void onSimulation(Session& session, const protocol::Message& message, protocol::Decoded<Params> decoded,
                  const std::string Params::*name, Make make) {
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  auto& params = std::get<Params>(decoded);
  if (auto runner = findRunner(session, message.id, params.*name)) {
    auto command = make(session.shared_from_this(), message.id, std::move(params));
    session.submit(message.id, std::move(runner), std::move(command));
  }
}

void simulationStep(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeStepParams(message.payload), &protocol::StepParams::simulation,
               makeStepCommand);
}

void simulationRun(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeStepParams(message.payload);
  if (auto* params = std::get_if<protocol::StepParams>(&decoded)) {
    params->until = UINT64_MAX;
  }
  onSimulation(session, message, std::move(decoded), &protocol::StepParams::simulation, makeStepCommand);
}

void simulationGet(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeGetParams(message.payload), &protocol::GetParams::simulation,
               makeGetCommand);
}

void simulationReset(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeResetParams(message.payload), &protocol::ResetParams::simulation,
               makeResetCommand);
}

void simulationSave(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeSaveParams(message.payload), &protocol::SaveParams::simulation,
               makeSaveCommand);
}

void simulationRestore(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeRestoreParams(message.payload), &protocol::RestoreParams::simulation,
               makeRestoreCommand);
}

void simulationPause(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeNameParams(message.payload, "simulation"), &protocol::NameParams::name,
               makePauseCommand);
}

void simulationSet(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeSetParams(message.payload), &protocol::SetParams::simulation,
               makeSetCommand);
}

void simulationEdit(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeEditParams(message.payload), &protocol::EditParams::simulation,
               makeEditCommand);
}

void simulationFork(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeForkParams(message.payload), &protocol::ForkParams::simulation,
               makeForkCommand);
}

void simulationTrace(Session& session, const protocol::Message& message) {
  onSimulation(session, message, protocol::decodeTraceParams(message.payload), &protocol::TraceParams::simulation,
               makeTraceCommand);
}

void simulationDelete(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeNameParams(message.payload, "simulation");
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  const std::string& name = std::get<protocol::NameParams>(decoded).name;
  if (session.core().findDamaged(name)) {
    runOnPool(session, message.id, [id = message.id, name](Session& self) {
      if (const auto problem = self.core().removeDamaged(name)) {
        self.respondError(id, {ErrorCode::Storage, *problem, {}});
      } else {
        self.respond(id, "{}");
      }
    });
    return;
  }
  if (const auto runner = findRunner(session, message.id, name)) {
    session.core().remove(name);
    deleteSimulation(session, message.id, runner);
  }
}

void simulationList(Session& session, const protocol::Message& message) {
  protocol::JsonWriter result;
  result.beginObject().key("simulations").beginArray();
  for (const auto& runner : session.core().all()) {
    write(result, runner->information());
  }
  for (const protocol::SimulationInformation& damaged : session.core().damaged()) {
    write(result, damaged);
  }
  session.respond(message.id, result.endArray().endObject().view());
}

// ---- environments ----

void environmentList(Session& session, const protocol::Message& message) {
  protocol::JsonWriter result;
  result.beginObject().key("environments").beginArray();
  for (const std::string& name : environment::processNames()) {
    result.beginObject().key("name").text(name);
    if (const auto process = environment::makeProcess(name, "")) {
      result.key("description").raw(protocol::encode(toDescribeResult((*process)->describe())));
    }
    // a schema is laid out over lines for people; a message is one line
    const std::string schema = "{\"schema\":" + environment::configurationSchema(name) + "}";
    result.key("schema").raw(protocol::memberOf(schema, "schema").value_or("{}")).endObject();
  }
  result.endArray().key("offered").texts(session.core().offered().names());
  session.respond(message.id, result.endObject().view());
}

void environmentOffer(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeNameParams(message.payload, "name");
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  const std::string& name = std::get<protocol::NameParams>(decoded).name;
  // the answer is queued before anybody can find the offer and ask
  protocol::JsonWriter result;
  result.beginObject().key("name").text(name).endObject();
  session.respond(message.id, result.view());
  const bool isReplacing = session.core().offered().offer(name, session.shared_from_this());
  session.core().log().info("offers environment '" + name + "'" + (isReplacing ? ", in place of an older offer" : ""),
                            {.session = session.id()});
}

// ---- the gallery ----

void modelList(Session& session, const protocol::Message& message) {
  protocol::JsonWriter result;
  result.beginObject().key("gallery").texts(galleryNames(session.core().options().galleryFolder)).endObject();
  session.respond(message.id, result.view());
}

// ---- streams ----

void streamOpen(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeStreamOpenParams(message.payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  auto& params = std::get<protocol::StreamOpenParams>(decoded);
  if (params.isInBlocks && !session.areBlocksAgreed()) {
    session.respondError(message.id, {ErrorCode::Capability,
                                      "params.bin: binary blocks were not agreed on. Name the capability 'bin' in "
                                      "hello, or leave bin out.",
                                      {}});
    return;
  }
  if (params.what == "geometry" && params.format == "glb" && !params.isInBlocks) {
    session.respondError(message.id,
                         protocol::fieldError("params.bin",
                                              "geometry as a file comes in binary blocks; say \"bin\": true, or "
                                              "\"format\": \"columns\" for tables"));
    return;
  }
  const auto runner = findRunner(session, message.id, params.simulation);
  if (runner == nullptr) {
    return;
  }
  auto stream = session.openStream(std::move(params), *runner);
  if (stream == nullptr) {
    const std::uint64_t bound = session.core().options().limits.streamsPerSession;
    session.respondError(message.id, protocol::limitError("streamsPerSession", bound + 1, bound, "Close one first."));
    return;
  }
  session.submit(message.id, runner, makeStreamOpenCommand(session.shared_from_this(), message.id, std::move(stream)));
}

void streamAck(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeStreamAckParams(message.payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  const auto& ack = std::get<protocol::StreamAckParams>(decoded);
  if (const auto stream = session.findStream(ack.stream)) {
    stream->acknowledge(ack);
    session.onDrained();
  }
  if (message.kind == protocol::Message::Kind::Request) {
    session.respond(message.id, "{}");
  }
}

void streamClose(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeNameParams(message.payload, "stream");
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  const std::string& name = std::get<protocol::NameParams>(decoded).name;
  if (session.closeStream(name)) {
    session.respond(message.id, "{}");
  } else {
    session.respondError(message.id, {ErrorCode::NotFound, "This session has no stream '" + name + "'.", {}});
  }
}

// ---- the server ----

void ping(Session& session, const protocol::Message& message) {
  session.respond(message.id, "{}");
}

void serverStatus(Session& session, const protocol::Message& message) {
  ServerCore& core = session.core();
  const auto runners = core.all();
  const auto running =
      std::count_if(runners.begin(), runners.end(), [](const auto& runner) { return runner->information().isRunning; });
  protocol::JsonWriter result;
  result.beginObject().key("server").text("espalier " + std::string(protocol::kProgramVersion));
  result.key("protocol").integer(protocol::kProtocolVersion).key("sessions").integer(core.sessionCount.load());
  result.key("simulations").integer(std::uint64_t{runners.size()});
  result.key("running").integer(static_cast<std::uint64_t>(running));
  result.key("workers").integer(core.pool().workers()).key("saving").boolean(core.store().isKept());
  result.key("offered").texts(core.offered().names());
  const auto seconds =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - core.started());
  result.key("uptimeSeconds").integer(static_cast<std::uint64_t>(seconds.count()));
  result.key("damaged").integer(std::uint64_t{core.damaged().size()});
  std::uint64_t stringBytes = 0;
  std::uint64_t streamBytes = 0;
  for (const auto& runner : runners) {
    stringBytes += runner->stringBytes();
    streamBytes += runner->streamBytes();
  }
  result.key("memory").beginObject().key("stringBytes").integer(stringBytes).key("streamBytes").integer(streamBytes);
  result.key("outboxBytes").integer(core.outboxBytes()).key("storeBytes").integer(core.store().bytes()).endObject();
  session.respond(message.id, result.endObject().view());
}

void cancel(Session& session, const protocol::Message& message) {
  auto decoded = protocol::decodeCancelParams(message.payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    session.respondError(message.id, *error);
    return;
  }
  session.cancelRequest(std::get<protocol::MessageId>(decoded));
  if (message.kind == protocol::Message::Kind::Request) {
    session.respond(message.id, "{}");
  }
}

struct Method {
  std::string_view name;
  void (*run)(Session&, const protocol::Message&);
  bool canBeNotification = false;  // also carried out without an id
};

constexpr std::array kMethods{
    Method{"model.check", modelCheck},
    Method{"model.load", modelLoad},
    Method{"model.list", modelList},
    Method{"simulation.create", simulationCreate},
    Method{"simulation.step", simulationStep},
    Method{"simulation.run", simulationRun},
    Method{"simulation.get", simulationGet},
    Method{"simulation.reset", simulationReset},
    Method{"simulation.save", simulationSave},
    Method{"simulation.restore", simulationRestore},
    Method{"simulation.pause", simulationPause},
    Method{"simulation.set", simulationSet},
    Method{"simulation.edit", simulationEdit},
    Method{"simulation.fork", simulationFork},
    Method{"simulation.trace", simulationTrace},
    Method{"simulation.list", simulationList},
    Method{"simulation.delete", simulationDelete},
    Method{"environment.list", environmentList},
    Method{"environment.offer", environmentOffer},
    Method{"stream.open", streamOpen},
    Method{"stream.ack", streamAck, true},
    Method{"stream.close", streamClose},
    Method{"server.status", serverStatus},
    Method{"ping", ping},
    Method{"$/cancel", cancel, true},
};

std::vector<std::string_view> methodNames() {
  std::vector<std::string_view> names{"hello"};
  for (const Method& method : kMethods) {
    names.push_back(method.name);
  }
  return names;
}

}  // namespace

void dispatch(Session& session, const protocol::Message& message) {
  const bool isRequest = message.kind == protocol::Message::Kind::Request;
  const auto method =
      std::find_if(kMethods.begin(), kMethods.end(), [&](const Method& m) { return m.name == message.method; });
  if (method == kMethods.end()) {
    if (isRequest) {
      session.respondError(message.id, {ErrorCode::UnknownMethod,
                                        "There is no method '" + message.method + "'. " +
                                            core::suggestName(message.method, methodNames()),
                                        {}});
    }
    return;
  }
  if (!isRequest && !method->canBeNotification) {
    // nobody would hear of its outcome
    session.core().log().debug("sent " + message.method + " without an id; it is ignored", {.session = session.id()});
    return;
  }
  if (isRequest && session.core().isShuttingDown()) {
    session.respondError(message.id,
                         {ErrorCode::ShuttingDown, "The server is shutting down. Ask again when it is back.", {}});
    return;
  }
  method->run(session, message);
}

}  // namespace espalier::server
