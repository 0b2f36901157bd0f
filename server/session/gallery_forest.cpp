#include "server/session/gallery_forest.h"

#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"

namespace espalier::server {

namespace {

namespace fs = std::filesystem;

// the file of a model folder that holds its world
constexpr const char* kWorldFile = "world.json";

protocol::Error forestError(const std::string& folder, const std::string& problem) {
  return {protocol::ErrorCode::InvalidParams, folder + kForestFile + "': " + problem, {}};
}

/// Decodes the JSON of a file.
template <typename Record>
protocol::Expected<Record> decodeText(const std::string& text,
                                      protocol::Expected<Record> (*decode)(const protocol::Payload&)) {
  if (const auto problem = protocol::jsonProblem(text)) {
    return tl::unexpected(protocol::Error{protocol::ErrorCode::InvalidParams, *problem, {}});
  }
  const auto message = protocol::decodeMessage(R"({"jsonrpc":"2.0","method":"file","params":)" + text + "}");
  if (!message) {
    return tl::unexpected(message.error().error);
  }
  return decode(message->payload);
}

/// A text of the folder; nothing: it has no such file.
using ReadText = std::function<std::optional<std::string>(const std::string& file)>;

/// The environment of a forest as the text of a list; empty: none.
std::string environmentOf(const protocol::ForestParams& forest, const std::string& gallery, const ReadText& read) {
  if (forest.environmentFile.empty()) {
    return asEnvironmentList(forest.environmentJson);
  }
  if (fs::path(forest.environmentFile).extension() == ".json") {
    return asEnvironmentList(read(forest.environmentFile).value_or(std::string()));
  }
  // an environment file (.e) of the gallery, by the name of its folder; a request brings its own environment
  return gallery.empty() ? std::string() : R"([{"type":"gallery","model":")" + gallery + "\"}]";
}

/// Reads from the gallery folder of a model, or from the files that came with it. `reference` must outlive the result.
ReadText readerOf(const std::string& galleryFolder, const protocol::ModelReference& reference) {
  const auto folder = reference.gallery ? galleryFolderOf(galleryFolder, *reference.gallery) : std::nullopt;
  return [&reference, folder](const std::string& file) -> std::optional<std::string> {
    if (folder) {
      DiskFileProvider files;
      const auto found = files.readInside(folder->string(), (*folder / file).string());
      return found ? std::optional(*found) : std::nullopt;
    }
    const auto found = reference.files.find(file);
    return found == reference.files.end() ? std::nullopt : std::optional(found->second);
  };
}

/// Replaces the name of the table of weather by its text. A sentence when there is no such table.
std::optional<std::string> embedWeather(protocol::WorldRecord& world, const ReadText& read) {
  if (world.weather.empty()) {
    return std::nullopt;
  }
  auto table = read(world.weather);
  if (!table) {
    return "there is no table of weather '" + world.weather + "': check 'weather'";
  }
  if (table->empty()) {  // which would mean no weather
    return "the table of weather '" + world.weather + "' is empty: check 'weather'";
  }
  world.weather = std::move(*table);
  return std::nullopt;
}

}  // namespace

std::optional<protocol::Error> expandForest(const std::string& galleryFolder, protocol::CreateParams& params) {
  const protocol::ModelReference& reference = params.model.model;
  if (!params.models.empty() || !params.plants.empty()) {
    return std::nullopt;
  }
  const std::string name = reference.gallery.value_or(std::string());
  const ReadText readText = readerOf(galleryFolder, reference);
  const auto text = readText(kForestFile);
  if (!text) {
    return std::nullopt;
  }
  const std::string place = name.empty() ? "The model's '" : "The gallery's '" + name + "/";
  auto read = decodeText(*text, protocol::decodeForestParams);
  if (!read) {
    return forestError(place, read.error().message);
  }
  auto& forest = *read;
  for (protocol::NamedModel& model : forest.models) {
    if (fs::path(model.file).filename() != fs::path(model.file)) {
      return forestError(place, "the model file '" + model.file + "' is not in the folder of the forest");
    }
    if (name.empty() && !reference.files.contains(model.file)) {
      return forestError(place, "the model file '" + model.file + "' did not come with the request");
    }
    model.model = params.model;
    model.model.model.main = model.file;
  }
  // the texts of the request are read before they go
  std::string environment;
  if (params.environmentTypes.empty()) {
    environment = environmentOf(forest, name, readText);
  }
  if (!params.world && forest.world) {
    if (const auto problem = embedWeather(*forest.world, readText)) {
      return forestError(place, *problem);
    }
    params.world = std::move(forest.world);
  }
  params.models = std::move(forest.models);
  params.plants = std::move(forest.plants);
  params.seeds = forest.seeds;
  if (params.name.empty() && !name.empty()) {
    params.name = name;
  }
  if (!params.seed) {
    params.seed = forest.seed;
  }
  if (!params.derivationLength) {
    params.derivationLength = forest.derivationLength;
  }
  if (params.environmentTypes.empty()) {
    params.environmentJson = environment;
  }
  return std::nullopt;
}

std::optional<protocol::Error> expandWorld(const std::string& galleryFolder, protocol::CreateParams& params) {
  const protocol::ModelReference& reference = params.model.model;
  // a file beside others is no folder's model
  if (params.world || (!reference.gallery && !reference.main.empty())) {
    return std::nullopt;
  }
  const ReadText readText = readerOf(galleryFolder, reference);
  const auto text = readText(kWorldFile);
  if (!text) {
    return std::nullopt;
  }
  const std::string file =
      (reference.gallery ? "The gallery's '" + *reference.gallery + "/" : std::string("The model's '")) + kWorldFile;
  auto world = decodeText(*text, protocol::decodeWorld);
  if (!world) {
    return protocol::Error{protocol::ErrorCode::InvalidParams, file + "': " + world.error().message, {}};
  }
  if (const auto problem = embedWeather(*world, readText)) {
    return protocol::Error{protocol::ErrorCode::InvalidParams, file + "': " + *problem, {}};
  }
  params.world = std::move(*world);
  return std::nullopt;
}

}  // namespace espalier::server
