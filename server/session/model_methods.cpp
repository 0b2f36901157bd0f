#include <algorithm>

#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/models/gallery.h"
#include "server/remote/models/model_files.h"
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
    return models.compile(params, session.core().limits().simulation);
  };
  auto compiled = compileMetered();
  if (!compiled) {
    session.respondError(request.id, compiled.error());
    return;
  }
  const auto& model = *compiled;
  protocol::ModelResult result = resultOf(model);
  if (isKept && !result.isValid) {
    session.respondError(request.id, toError(model.result.diagnostics.entries()));
    return;
  }
  if (isKept) {
    auto kept = models.keep(model);
    if (!kept) {
      session.respondError(request.id, kept.error());
      return;
    }
    result.model = *kept;
    // it is kept as long as the server runs
    session.account().add(MemoryKind::Compiling, std::max<std::int64_t>(memory.net(), 0));
  }
  session.respond(request.id, protocol::encode(result));
}

std::vector<std::string> namesOf(const language::Program& program) {
  std::vector<std::string> names;
  for (const auto& file : program.sources) {
    names.push_back(file.name);
  }
  return names;
}

/// An object of texts. Names may be any text.
void writeTexts(protocol::JsonWriter& result, const std::map<std::string, std::string>& texts) {
  std::string members;
  for (const auto& [name, text] : texts) {
    protocol::JsonWriter key;
    protocol::JsonWriter value;
    members += (members.empty() ? "" : ",") + key.text(name).take() + ":" + value.text(text).take();
  }
  result.beginObject();
  if (!members.empty()) {
    result.raw(members);
  }
  result.endObject();
}

/// Answers model.read. Files that are no text go as base64. `revision` is that of a saved model.
void writeFiles(const Request& request, const GalleryModel& model, const std::string& environmentJson,
                const std::string& revision = {}) {
  std::map<std::string, std::string> texts;
  std::map<std::string, std::string> binary;
  for (const auto& [name, bytes] : model.files) {
    if (protocol::isPlainText(bytes)) {
      texts.emplace(name, bytes);
    } else {
      binary.emplace(name, protocol::toBase64(bytes));
    }
  }
  protocol::JsonWriter result;
  result.beginObject().key("main").text(model.main).key("files");
  writeTexts(result, texts);
  result.key("binaryFiles");
  writeTexts(result, binary);
  if (!environmentJson.empty()) {
    // a message is one line
    std::string line = environmentJson;
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    result.key("environment").raw(line);
  }
  if (!revision.empty()) {
    result.key("revision").text(revision);
  }
  request.session.respond(request.id, result.endObject().view());
}

/// The file of a saved model that is the model: as a folder says it, else the first that could be one.
std::string mainOf(const std::map<std::string, std::string>& files) {
  if (const FoundModel found = findModelFiles(files, {})) {
    return found->model;
  }
  for (const char* suffix : {".l", ".lpy", ".ls", ".lsv", ".txt"}) {
    for (const auto& [name, bytes] : files) {
      if (name.ends_with(suffix)) {
        return name;
      }
    }
  }
  return files.empty() ? std::string() : files.begin()->first;
}

void readSaved(const Request& request, const std::string& name) {
  ServerCore& core = request.session.core();
  auto saved = core.savedModels().read(name);
  if (!saved) {
    request.session.respondError(request.id, saved.error());
    return;
  }
  GalleryModel model{.main = mainOf(saved->files), .files = {}};
  model.files = std::move(saved->files);
  // it is not compiled: a model with errors is read too, so that they can be mended
  writeFiles(request, model, {}, saved->revision);
}

}  // namespace

namespace methods {

void modelCheck(const Request& request, protocol::ModelParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) { compileModel(self, params, false); });
}

void modelLoad(const Request& request, protocol::ModelParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) { compileModel(self, params, true); });
}

void modelRead(const Request& request, protocol::ReadModelParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) {
    if (!params.saved.empty()) {
      readSaved(self, params.saved);
      return;
    }
    const std::string& gallery = self.session.core().options().galleryFolder;
    protocol::ModelParams model;
    model.model.gallery = params.gallery;
    // the compiler finds out which files it reads
    const auto compiled = self.session.core().models().compile(model, self.session.core().limits().simulation);
    if (!compiled) {
      self.session.respondError(self.id, compiled.error());
      return;
    }
    const auto& found = *compiled;
    if (found.result.program == nullptr) {
      self.session.respondError(self.id, toError(found.result.diagnostics.entries()));
      return;
    }
    writeFiles(self, readGalleryModel(gallery, params.gallery, namesOf(*found.result.program)), found.environmentJson);
  });
}

void modelList(const Request& request, protocol::NoParams) {
  // the files of the gallery are read for their entries
  runOnWorker(request, [](const Request& self) {
    const std::string& folder = self.session.core().options().galleryFolder;
    protocol::JsonWriter result;
    result.beginObject().key("gallery").texts(galleryNames(folder));
    const std::vector<std::string> entries = galleryEntries(folder);
    result.key("entries").texts(entries).key("pictures");
    writeTexts(result, galleryPictures(folder, entries));
    // its absence says that nothing can be saved
    if (const SavedModels& saved = self.session.core().savedModels(); saved.isOn()) {
      result.key("saved").texts(saved.names());
    }
    result.endObject();
    self.session.respond(self.id, result.view());
  });
}

void modelSave(const Request& request, protocol::SaveModelParams params) {
  runOnWorker(request, [params = std::move(params)](const Request& self) {
    const auto revision = self.session.core().savedModels().save(params);
    if (!revision) {
      self.session.respondError(self.id, revision.error());
      return;
    }
    protocol::JsonWriter result;
    result.beginObject().key("revision").text(*revision).endObject();
    self.session.respond(self.id, result.view());
  });
}

}  // namespace methods
}  // namespace espalier::server
