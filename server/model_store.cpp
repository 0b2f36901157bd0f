#include "server/model_store.h"

#include <algorithm>
#include <filesystem>

#include "engine/core/diagnostic.h"
#include "server/disk_files.h"
#include "server/translate.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// The only file with the suffix in the folder, that of the given stem first; empty when there is none or a choice.
std::string fileWithSuffix(const fs::path& folder, const std::string& stem, const std::string& suffix) {
  std::error_code error;
  const fs::path named = folder / (stem + suffix);
  if (fs::is_regular_file(named, error)) {
    return named.string();
  }
  std::string found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == suffix) {
      if (!found.empty()) {
        return {};
      }
      found = entry.path().string();
    }
  }
  return found;
}

/// The view file beside a model among files on the wire.
std::string viewBeside(const std::map<std::string, std::string>& files, const std::string& model) {
  const std::string view = fs::path(model).replace_extension(".v").string();
  return files.contains(view) ? view : std::string();
}

std::vector<std::string> galleryNames(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory()) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::variant<CompiledModel, protocol::Error> ModelStore::compileGallery(const std::string& name,
                                                                        language::CompileInput input) const {
  const auto names = galleryNames(galleryFolder_);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const std::vector<std::string_view> views(names.begin(), names.end());
    return protocol::Error{protocol::ErrorCode::NotFound,
                           names.empty() ? "This server has no gallery. Start it with --gallery FOLDER, or send the source."
                                         : "There is no gallery model '" + name + "'. " + core::suggestName(name, views),
                           {}};
  }
  const fs::path folder = fs::path(galleryFolder_) / name;
  input.modelFile = fileWithSuffix(folder, name, ".l");
  if (input.modelFile.empty()) {
    return protocol::Error{protocol::ErrorCode::NotFound,
                           "The gallery folder '" + name + "' holds no model, or several without one called " + name +
                               ".l. Send the source instead.",
                           {}};
  }
  input.viewFile = fileWithSuffix(folder, fs::path(input.modelFile).stem().string(), ".v");
  DiskFileProvider files;
  CompiledModel compiled{language::compile(input, files), {}};
  compiled.environmentJson = files.read((folder / "environment.json").string()).value_or("");
  return compiled;
}

std::variant<CompiledModel, protocol::Error> ModelStore::compile(const protocol::ModelParams& params,
                                                                 const core::Limits& limits) const {
  const protocol::ModelReference& model = params.model;
  if (model.loaded) {
    const std::lock_guard lock(mutex_);
    const auto found = loaded_.find(*model.loaded);
    if (found == loaded_.end()) {
      return protocol::Error{protocol::ErrorCode::NotFound,
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
