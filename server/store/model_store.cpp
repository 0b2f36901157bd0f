#include "server/store/model_store.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "engine/core/diagnostic.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/remote/disk_files.h"
#include "server/remote/gallery.h"
#include "server/remote/translation/translate.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kNamePrefix = "model-";

std::uint64_t numberIn(std::string_view name) {
  std::uint64_t number = 0;
  name.remove_prefix(std::min(name.size(), kNamePrefix.size()));
  std::from_chars(name.data(), name.data() + name.size(), number);
  return number;
}

/// The view file beside a model among files on the wire.
std::string viewBeside(const std::map<std::string, std::string>& files, const std::string& model) {
  // without its entry
  const std::string view = fs::path(model.substr(0, model.find(':'))).replace_extension(".v").string();
  return files.contains(view) ? view : std::string();
}

std::string_view compatibilityName(core::Compatibility compatibility) {
  switch (compatibility) {
    case core::Compatibility::Cpfg:
      return "cpfg";
    case core::Compatibility::CpfgBatch:
      return "cpfg-batch";
    case core::Compatibility::Espalier:
      break;
  }
  return "";
}

/// A compiled model with all its files, as text for the disk.
std::string toText(const CompiledModel& model) {
  const language::Program& program = *model.result.program;
  protocol::JsonWriter text;
  text.beginObject().key("main").text(program.modelFile).key("view").text(program.viewFile);
  text.key("compatibility").text(compatibilityName(program.compatibility));
  text.key("files").beginObject();
  for (const auto& file : program.sources) {
    text.key(file.name).text(file.text);
  }
  text.endObject().key("defines").beginObject();
  for (const auto& [name, value] : program.defines) {
    text.key(name).text(value);
  }
  text.endObject().key("environment").text(model.environmentJson);
  return text.endObject().take();
}

CompiledModel compileText(const std::string& text, const core::Limits& limits) {
  const auto texts = [&text](std::string_view name) {
    return protocol::textsOf(text, name).value_or(std::map<std::string, std::string>());
  };
  language::CompileInput input;
  input.modelFile = protocol::memberOf(text, "main").value_or("");
  input.viewFile = protocol::memberOf(text, "view").value_or("");
  input.compatibility = toCompatibility(protocol::memberOf(text, "compatibility").value_or(""));
  const auto defines = texts("defines");
  input.defines.assign(defines.begin(), defines.end());
  input.limits = limits;
  core::MemoryFileProvider files(texts("files"));
  return {language::compile(input, files), protocol::memberOf(text, "environment").value_or("")};
}

}  // namespace

void ModelStore::loadKept() {
  const std::lock_guard lock(mutex_);
  for (auto& [name, text] : store_->models()) {
    lastNumber_ = std::max(lastNumber_, numberIn(name));
    kept_.emplace(name, std::move(text));
  }
}

std::variant<CompiledModel, protocol::Error> ModelStore::compileGallery(const std::string& whole,
                                                                        const std::string& asked,
                                                                        language::CompileInput input) const {
  // NAME/FILE:ENTRY
  const std::size_t slash = asked.empty() ? whole.find('/') : std::string::npos;
  const std::string name = whole.substr(0, slash);
  const std::string file = slash == std::string::npos ? asked : whole.substr(slash + 1);
  const auto folder = galleryFolderOf(galleryFolder_, name);
  if (!folder) {
    const auto names = galleryNames(galleryFolder_);
    const std::vector<std::string_view> views(names.begin(), names.end());
    return protocol::Error{protocol::ErrorCode::NotFound,
                           names.empty()
                               ? "This server has no gallery. Start it with --gallery FOLDER, or send the source."
                               : "There is no gallery model '" + name + "'. " + core::suggestName(name, views),
                           {}};
  }
  // no path leads out of the folder; an entry may hold slashes
  const std::size_t colon = std::min(file.find(':'), file.size());
  input.modelFile = file.empty() ? fileWithSuffix(*folder, name, ".l")
                                 : (*folder / fs::path(file.substr(0, colon)).filename()).string() + file.substr(colon);
  if (input.modelFile.empty()) {
    return protocol::Error{protocol::ErrorCode::NotFound,
                           "The gallery folder '" + name + "' holds no model, or several without one called " + name +
                               ".l. model.list names its models: NAME/FILE:ENTRY. Or send the source.",
                           {}};
  }
  const bool isOneOfMany = slash != std::string::npos;
  const std::string stem = fs::path(isOneOfMany ? file.substr(0, colon) : input.modelFile).stem().string();
  std::error_code error;
  const auto beside = [&](const char* suffix) {
    const fs::path companion = *folder / (stem + suffix);
    return fs::is_regular_file(companion, error) ? companion.string() : std::string{};
  };
  input.viewFile = isOneOfMany ? beside(".v") : fileWithSuffix(*folder, stem, ".v");
  DiskFileProvider files;
  CompiledModel compiled{language::compile(input, files), {}};
  // its own environment, for simulations that name none
  if (isOneOfMany && beside(".e").empty()) {
    return compiled;
  }
  if (!fileWithSuffix(*folder, name, ".e").empty()) {
    protocol::JsonWriter entry;
    entry.beginArray().beginObject().key("type").text("gallery").key("model").text(name).endObject().endArray();
    compiled.environmentJson = entry.take();
  } else if (const std::string json = fileWithSuffix(*folder, name, ".json");
             !json.empty() && fs::path(json).filename() != kForestFile) {
    compiled.environmentJson = asEnvironmentList(files.read(json).value_or(std::string()));
  }
  return compiled;
}

std::variant<CompiledModel, protocol::Error> ModelStore::findLoaded(const std::string& name,
                                                                    const core::Limits& limits) const {
  const std::lock_guard lock(mutex_);
  if (const auto found = loaded_.find(name); found != loaded_.end()) {
    return found->second;
  }
  const auto found = kept_.find(name);
  if (found == kept_.end()) {
    return protocol::Error{protocol::ErrorCode::NotFound,
                           "There is no loaded model '" + name + "'. Load it with model.load, or send its source.",
                           {}};
  }
  CompiledModel compiled = compileText(found->second, limits);
  if (compiled.result.program != nullptr) {
    loaded_.emplace(name, compiled);
    kept_.erase(found);
  }
  return compiled;
}

std::variant<CompiledModel, protocol::Error> ModelStore::compile(const protocol::ModelParams& params,
                                                                 const core::Limits& limits) const {
  const protocol::ModelReference& model = params.model;
  if (model.loaded) {
    return findLoaded(*model.loaded, limits);
  }
  language::CompileInput input;
  input.compatibility = toCompatibility(params.compatibility);
  input.defines = params.defines;
  input.limits = limits;
  if (model.gallery) {
    return compileGallery(*model.gallery, model.main, std::move(input));
  }
  core::MemoryFileProvider files;
  if (model.source) {
    input.modelFile = "model.l";
    files.add("model.l", *model.source);
  } else {
    input.modelFile = model.main;
    input.viewFile = viewBeside(model.files, model.main);
    files = core::MemoryFileProvider(model.files);
  }
  return CompiledModel{language::compile(input, files), {}};
}

std::variant<std::string, protocol::Error> ModelStore::keep(const CompiledModel& model) {
  const std::lock_guard lock(mutex_);
  const std::size_t count = loaded_.size() + kept_.size();
  if (count >= kMaximumLoaded) {
    return protocol::limitError("loadedModels", count + 1, kMaximumLoaded,
                                "Send the source with simulation.create instead.");
  }
  std::string name = std::string(kNamePrefix) + std::to_string(lastNumber_ + 1);
  if (const auto problem = store_->saveModel(name, toText(model))) {
    return protocol::Error{protocol::ErrorCode::Storage, *problem, {}};
  }
  ++lastNumber_;
  loaded_.emplace(name, model);
  return name;
}

}  // namespace espalier::server
