#include "server/store/model_store.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "engine/core/diagnostic.h"
#include "engine/files/utf8.h"
#include "protocol/base64.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/folder_settings.h"
#include "server/remote/models/gallery.h"
#include "server/remote/models/model_files.h"
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

// a colour file as the name under which its bytes are kept: place in the command, block, kind
std::string colourName(std::size_t place, const files::ColourFile& colours) {
  return std::to_string(place) + ":" + std::to_string(colours.block) + (colours.isMaterial ? ":mat" : ":map");
}

files::ColourFile colourFileOf(const std::string& name) {
  files::ColourFile result{.file = name, .isMaterial = name.ends_with(":mat")};
  const std::size_t colon = name.find(':');
  std::from_chars(name.data() + colon + 1, name.data() + name.size(), result.block);
  return result;
}

files::Palette paletteOf(const CompiledModel& model) {
  files::FolderCommand command;
  command.colourBase = model.colourBase;
  for (const auto& [name, bytes] : model.colourFiles) {
    command.colours.push_back(colourFileOf(name));
  }
  core::MemoryFileProvider files(model.colourFiles);
  core::DiagnosticList diagnostics;
  return files::readPalette(command, files, diagnostics);
}

/// Compiles the model of a folder with all that the folder says about it.
CompiledModel compileFolder(const ModelFiles& found, language::CompileInput input, core::FileProvider& files) {
  input.modelFile = found.model;
  input.viewFile = found.view;
  CompiledModel compiled{.result = language::compile(input, files)};
  core::DiagnosticList remarks;
  for (const core::Diagnostic& remark : found.remarks) {
    remarks.add(remark);
  }
  const FolderSettings settings = readFolderSettings(found, false, files, remarks);
  for (const core::Diagnostic& remark : remarks.entries()) {
    // notes are for people at the folder
    if (remark.severity == core::Severity::Warning) {
      compiled.result.diagnostics.add(remark);
    }
  }
  compiled.palette = settings.palette;
  compiled.colourBase = found.colourBase;
  for (std::size_t i = 0; i < found.colours.size(); ++i) {
    if (auto bytes = files.read(found.colours[i].file)) {
      compiled.colourFiles.emplace(colourName(i, found.colours[i]), std::move(*bytes));
    }
  }
  if (compiled.result.program != nullptr) {
    compiled.lastStep = lastFrameOf(settings, compiled.result.program->derivationLength);
  }
  return compiled;
}

core::DiagnosticList renamedWithin(const std::string& gallery, const core::DiagnosticList& diagnostics) {
  core::DiagnosticList renamed;
  for (core::Diagnostic diagnostic : diagnostics.entries()) {
    diagnostic.message = withinGallery(gallery, std::move(diagnostic.message));
    diagnostic.hint = withinGallery(gallery, std::move(diagnostic.hint));
    diagnostic.location.file = withinGallery(gallery, std::move(diagnostic.location.file));
    diagnostic.location.expansion = withinGallery(gallery, std::move(diagnostic.location.expansion));
    renamed.add(std::move(diagnostic));
  }
  return renamed;
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
  text.endObject().key("colours").beginObject();
  for (const auto& [name, bytes] : model.colourFiles) {
    text.key(name).text(protocol::toBase64(bytes));
  }
  text.endObject().key("colourBase").integer(static_cast<std::uint64_t>(model.colourBase));
  if (model.lastStep) {
    text.key("lastStep").integer(*model.lastStep);
  }
  text.key("environment").text(model.environmentJson);
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
  CompiledModel compiled{.result = language::compile(input, files)};
  compiled.environmentJson = protocol::memberOf(text, "environment").value_or("");
  for (const auto& [name, bytes] : texts("colours")) {
    compiled.colourFiles.emplace(name, protocol::fromBase64(bytes).value_or(""));
  }
  const auto number = [&text](std::string_view name) -> std::optional<std::uint64_t> {
    std::uint64_t value = 0;
    const auto found = protocol::memberOf(text, name);
    return found && std::from_chars(found->data(), found->data() + found->size(), value).ec == std::errc()
               ? std::optional(value)
               : std::nullopt;
  };
  compiled.colourBase = static_cast<int>(number("colourBase").value_or(1));
  compiled.lastStep = number("lastStep");
  compiled.palette = paletteOf(compiled);
  return compiled;
}

/// The environment that a folder from the wire brings, as the text of a list; empty: none.
std::string environmentOf(const ModelFiles& found, const std::map<std::string, std::string>& files) {
  const auto file = files.find(found.environment);
  if (file == files.end()) {
    return {};
  }
  if (found.environment.ends_with(".json")) {
    return asEnvironmentList(file->second);
  }
  protocol::JsonWriter list;
  list.beginArray().beginObject().key("type").text("field").key("main").text(found.environment).key("files");
  list.beginObject();
  for (const auto& [name, content] : files) {
    if (files::asUtf8(content) == content) {
      list.key(name).text(content);
    }
  }
  return list.endObject().endObject().endArray().take();
}

}  // namespace

void ModelStore::loadKept() {
  const std::lock_guard lock(mutex_);
  for (auto& [name, text] : store_->models()) {
    lastNumber_ = std::max(lastNumber_, numberIn(name));
    kept_.emplace(name, std::move(text));
  }
}

protocol::Expected<CompiledModel> ModelStore::compileGallery(const std::string& whole, const std::string& asked,
                                                             language::CompileInput input) const {
  // NAME/FILE:ENTRY
  const std::size_t slash = asked.empty() ? whole.find('/') : std::string::npos;
  const std::string name = whole.substr(0, slash);
  const std::string file = slash == std::string::npos ? asked : whole.substr(slash + 1);
  const auto folder = galleryFolderOf(galleryFolder_, name);
  if (!folder) {
    const auto names = galleryNames(galleryFolder_);
    const std::vector<std::string_view> views(names.begin(), names.end());
    return tl::unexpected(protocol::Error{
        protocol::ErrorCode::NotFound,
        names.empty() ? "This server has no gallery. Start it with --gallery FOLDER, or send the source."
                      : "There is no gallery model '" + name + "'. " + core::suggestName(name, views),
        {}});
  }
  // no path leads out of the folder; an entry may hold slashes
  const std::size_t colon = std::min(file.find(':'), file.size());
  const std::string inFolder = (*folder / fs::path(file.substr(0, colon)).filename()).string() + file.substr(colon);
  const auto found = findModelFiles(file.empty() ? folder->string() : inFolder);
  if (!found) {
    return tl::unexpected(protocol::Error{protocol::ErrorCode::NotFound,
                                          "The gallery model '" + whole +
                                              "' cannot be used: " + withinGallery(galleryFolder_, found.error()) +
                                              ". model.list names the models of the gallery: NAME/FILE:ENTRY.",
                                          {}});
  }
  DiskFileProvider files;
  CompiledModel compiled = compileFolder(*found, std::move(input), files);
  compiled.result.diagnostics = renamedWithin(galleryFolder_, compiled.result.diagnostics);
  // its own environment, for simulations that name none
  const bool isOneOfMany = slash != std::string::npos;
  if (isOneOfMany && !found->environment.ends_with(".e")) {
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

protocol::Expected<CompiledModel> ModelStore::findLoaded(const std::string& name, const core::Limits& limits) const {
  const std::lock_guard lock(mutex_);
  if (const auto found = loaded_.find(name); found != loaded_.end()) {
    return found->second;
  }
  const auto found = kept_.find(name);
  if (found == kept_.end()) {
    return tl::unexpected(
        protocol::Error{protocol::ErrorCode::NotFound,
                        "There is no loaded model '" + name + "'. Load it with model.load, or send its source.",
                        {}});
  }
  CompiledModel compiled = compileText(found->second, limits);
  if (compiled.result.program != nullptr) {
    loaded_.emplace(name, compiled);
    kept_.erase(found);
  }
  return compiled;
}

protocol::Expected<CompiledModel> ModelStore::compile(const protocol::ModelParams& params,
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
  if (model.source) {
    input.modelFile = "model.l";
    core::MemoryFileProvider files({{"model.l", *model.source}});
    return CompiledModel{.result = language::compile(input, files)};
  }
  const auto found = findModelFiles(model.files, model.main);
  if (!found) {
    return tl::unexpected(protocol::memberError("params.model.files", found.error()));
  }
  core::MemoryFileProvider files(model.files);
  CompiledModel compiled = compileFolder(*found, std::move(input), files);
  compiled.environmentJson = environmentOf(*found, model.files);
  return compiled;
}

protocol::Expected<std::string> ModelStore::keep(const CompiledModel& model) {
  const std::lock_guard lock(mutex_);
  const std::size_t count = loaded_.size() + kept_.size();
  if (count >= kMaximumLoaded) {
    return tl::unexpected(protocol::limitError("loadedModels", count + 1, kMaximumLoaded,
                                               "Send the source with simulation.create instead."));
  }
  std::string name = std::string(kNamePrefix) + std::to_string(lastNumber_ + 1);
  if (const auto problem = store_->saveModel(name, toText(model))) {
    return tl::unexpected(protocol::Error{protocol::ErrorCode::Storage, *problem, {}});
  }
  ++lastNumber_;
  loaded_.emplace(name, model);
  return name;
}

}  // namespace espalier::server
