#include "server/model_store.h"

#include <filesystem>

#include "engine/core/diagnostic.h"
#include "protocol/json_writer.h"
#include "server/disk_files.h"
#include "server/gallery.h"
#include "server/translate.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// The view file beside a model among files on the wire.
std::string viewBeside(const std::map<std::string, std::string>& files, const std::string& model) {
  const std::string view = fs::path(model).replace_extension(".v").string();
  return files.contains(view) ? view : std::string();
}

}  // namespace

std::variant<CompiledModel, protocol::Error> ModelStore::compileGallery(const std::string& name,
                                                                        language::CompileInput input) const {
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
  input.modelFile = fileWithSuffix(*folder, name, ".l");
  if (input.modelFile.empty()) {
    return protocol::Error{protocol::ErrorCode::NotFound,
                           "The gallery folder '" + name + "' holds no model, or several without one called " + name +
                               ".l. Send the source instead.",
                           {}};
  }
  input.viewFile = fileWithSuffix(*folder, fs::path(input.modelFile).stem().string(), ".v");
  DiskFileProvider files;
  CompiledModel compiled{language::compile(input, files), {}};
  // its own environment, for simulations that name none
  if (!fileWithSuffix(*folder, name, ".e").empty()) {
    protocol::JsonWriter entry;
    entry.beginArray().beginObject().key("type").text("gallery").key("model").text(name).endObject().endArray();
    compiled.environmentJson = entry.take();
  }
  return compiled;
}

std::variant<CompiledModel, protocol::Error> ModelStore::compile(const protocol::ModelParams& params,
                                                                 const core::Limits& limits) const {
  const protocol::ModelReference& model = params.model;
  if (model.loaded) {
    const std::lock_guard lock(mutex_);
    const auto found = loaded_.find(*model.loaded);
    if (found == loaded_.end()) {
      return protocol::Error{
          protocol::ErrorCode::NotFound,
          "There is no loaded model '" + *model.loaded + "'. Load it with model.load, or send its source.",
          {}};
    }
    return found->second;
  }
  language::CompileInput input;
  input.compatibility = toCompatibility(params.compatibility);
  input.defines = params.defines;
  input.limits = limits;
  if (model.gallery) {
    return compileGallery(*model.gallery, std::move(input));
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
  if (loaded_.size() >= kMaximumLoaded) {
    return protocol::limitError("loadedModels", loaded_.size() + 1, kMaximumLoaded,
                                "Send the source with simulation.create instead.");
  }
  std::string name = "model-" + std::to_string(++lastNumber_);
  loaded_.emplace(name, model);
  return name;
}

}  // namespace espalier::server
