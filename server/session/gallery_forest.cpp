#include "server/session/gallery_forest.h"

#include <filesystem>
#include <utility>

#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"

namespace espalier::server {

namespace {

namespace fs = std::filesystem;

protocol::Error forestError(const std::string& gallery, const std::string& problem) {
  return {protocol::ErrorCode::InvalidParams, "The gallery's '" + gallery + "/" + kForestFile + "': " + problem, {}};
}

protocol::Expected<protocol::ForestParams> readForest(const std::string& text) {
  if (const auto problem = protocol::jsonProblem(text)) {
    return tl::unexpected(protocol::Error{protocol::ErrorCode::InvalidParams, *problem, {}});
  }
  const auto message = protocol::decodeMessage(R"({"jsonrpc":"2.0","method":"forest","params":)" + text + "}");
  if (!message) {
    return tl::unexpected(message.error().error);
  }
  return protocol::decodeForestParams(message->payload);
}

/// The environment of a forest as the text of a list; empty: none.
std::string environmentOf(const protocol::ForestParams& forest, const std::string& gallery, const fs::path& folder) {
  if (forest.environmentFile.empty()) {
    return asEnvironmentList(forest.environmentJson);
  }
  if (fs::path(forest.environmentFile).extension() == ".json") {
    DiskFileProvider files;
    return asEnvironmentList(
        files.readInside(folder.string(), (folder / forest.environmentFile).string()).value_or(std::string()));
  }
  // an environment file (.e) of the gallery, by the name of its folder
  return R"([{"type":"gallery","model":")" + gallery + "\"}]";
}

}  // namespace

std::optional<protocol::Error> expandGalleryForest(const std::string& galleryFolder, protocol::CreateParams& params) {
  const auto& gallery = params.model.model.gallery;
  if (!gallery || !params.models.empty() || !params.plants.empty()) {
    return std::nullopt;
  }
  const std::string name = *gallery;
  const auto folder = galleryFolderOf(galleryFolder, name);
  if (!folder) {
    return std::nullopt;
  }
  DiskFileProvider files;
  const auto text = files.readInside(folder->string(), (*folder / kForestFile).string());
  if (!text) {
    return std::nullopt;
  }
  auto read = readForest(*text);
  if (!read) {
    return forestError(name, read.error().message);
  }
  auto& forest = *read;
  for (protocol::NamedModel& model : forest.models) {
    if (fs::path(model.file).filename() != fs::path(model.file)) {
      return forestError(name, "the model file '" + model.file + "' is not in the folder of the forest");
    }
    model.model = params.model;
    model.model.model.main = model.file;
  }
  params.models = std::move(forest.models);
  params.plants = std::move(forest.plants);
  params.seeds = forest.seeds;
  if (params.name.empty()) {
    params.name = name;
  }
  if (!params.seed) {
    params.seed = forest.seed;
  }
  if (!params.derivationLength) {
    params.derivationLength = forest.derivationLength;
  }
  if (params.environmentTypes.empty()) {
    params.environmentJson = environmentOf(forest, name, *folder);
  }
  return std::nullopt;
}

}  // namespace espalier::server
