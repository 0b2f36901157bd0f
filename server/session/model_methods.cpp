#include <algorithm>

#include "protocol/codec.h"
#include "server/remote/gallery.h"
#include "server/remote/translation/translate.h"
#include "server/running/turn_meter.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

protocol::ModelResult resultOf(const CompiledModel& model) {
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
  return result;
}

/// Compiles a model and answers. `isKept`: under an identifier, for later requests.
void compileModel(const Request& request, const protocol::ModelParams& params, bool isKept) {
  Session& session = request.session;
  ModelStore& models = session.core().models();
  PartMeter memory;
  const auto compileMetered = [&] {
    const core::WorkMeter::Scope scope(&memory);
    return models.compile(params, session.core().options().limits.simulation);
  };
  auto compiled = compileMetered();
  if (const auto* error = std::get_if<protocol::Error>(&compiled)) {
    session.respondError(request.id, *error);
    return;
  }
  const auto& model = std::get<CompiledModel>(compiled);
  protocol::ModelResult result = resultOf(model);
  if (isKept && !result.isValid) {
    session.respondError(request.id, toError(model.result.diagnostics.entries()));
    return;
  }
  if (isKept) {
    auto kept = models.keep(model);
    if (const auto* error = std::get_if<protocol::Error>(&kept)) {
      session.respondError(request.id, *error);
      return;
    }
    result.model = std::get<std::string>(kept);
    // it is kept as long as the server runs
    session.account().add(MemoryKind::Compiling, std::max<std::int64_t>(memory.net(), 0));
  }
  session.respond(request.id, protocol::encode(result));
}

}  // namespace

namespace methods {

void modelCheck(const Request& request, protocol::ModelParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) { compileModel(self, params, false); });
}

void modelLoad(const Request& request, protocol::ModelParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) { compileModel(self, params, true); });
}

void modelList(const Request& request, protocol::NoParams) {
  // the files of the gallery are read for their entries
  runOnWorker(request, [](const Request& self) {
    const std::string& folder = self.session.core().options().galleryFolder;
    protocol::JsonWriter result;
    result.beginObject().key("gallery").texts(galleryNames(folder));
    result.key("entries").texts(galleryEntries(folder)).endObject();
    self.session.respond(self.id, result.view());
  });
}

}  // namespace methods
}  // namespace espalier::server
