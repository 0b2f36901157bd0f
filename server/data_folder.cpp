#include "server/data_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "protocol/codec.h"
#include "server/disk_files.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// The record in the form of the request that made it, so that one decoder reads both.
std::string toText(const SimulationRecord& record) {
  const protocol::CreateParams& create = record.create;
  protocol::JsonWriter params;
  params.beginObject().key("model").beginObject().key("loaded").text("snapshot").endObject();
  params.key("name").text(create.name).key("seed").integer(record.seed).key("seedGiven").boolean(record.hasSeed);
  if (!create.environmentJson.empty()) {
    params.key("environment").raw(create.environmentJson);
  }
  if (create.derivationLength) {
    params.key("derivationLength").integer(*create.derivationLength);
  }
  params.key("plants").beginArray();
  for (const protocol::PlantPosition& plant : create.plants) {
    params.beginObject().key("position").numbers(plant.position).endObject();
  }
  params.endArray().key("limits").beginObject();
  if (create.maximumModules) {
    params.key("modules").integer(*create.maximumModules);
  }
  if (create.maximumQueries) {
    params.key("queries").integer(*create.maximumQueries);
  }
  params.endObject().endObject();
  return protocol::encodeNotification("simulation.create", params.take());
}

std::variant<SimulationRecord, std::string> toRecord(const std::string& id, std::string_view text) {
  while (!text.empty() && text.back() == '\n') {
    text.remove_suffix(1);
  }
  const auto message = protocol::decodeMessage(text);
  if (const auto* bad = std::get_if<protocol::BadMessage>(&message)) {
    return bad->error.message;
  }
  const protocol::Payload& payload = std::get<protocol::Message>(message).payload;
  auto decoded = protocol::decodeCreateParams(payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return error->message;
  }
  SimulationRecord record;
  record.id = id;
  record.create = std::move(std::get<protocol::CreateParams>(decoded));
  record.seed = record.create.seed.value_or(0);
  record.hasSeed = protocol::memberOf(payload.toText(), "seedGiven") == "true";
  return record;
}

}  // namespace

std::string DataFolder::fileOf(const std::string& id, std::string_view suffix) const {
  return (fs::path(folder_) / "simulations" / (id + std::string(suffix))).string();
}

std::optional<std::string> DataFolder::prepare() {
  if (!isKept()) {
    return std::nullopt;
  }
  std::error_code error;
  fs::create_directories(fs::path(folder_) / "simulations", error);
  if (error) {
    return "cannot use the data folder '" + folder_ + "': " + error.message() +
           ". Give --data a folder that can be written.";
  }
  const std::string lockName = (fs::path(folder_) / "lock").string();
  const int descriptor = open(lockName.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    return "cannot use the data folder '" + folder_ + "': " + std::generic_category().message(errno) +
           ". Give --data a folder that can be written.";
  }
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    close(descriptor);
    return "the data folder '" + folder_ + "' is used by another server. Stop it, or give --data another folder.";
  }
  lock_ = std::shared_ptr<const int>(new int(descriptor), [](const int* held) {
    close(*held);
    delete held;
  });
  return std::nullopt;
}

std::optional<std::string> DataFolder::saveRecord(const SimulationRecord& record) const {
  return writeFileAtomically(fileOf(record.id, ".json"), toText(record));
}

std::optional<std::string> DataFolder::saveSnapshot(const std::string& id, std::string_view snapshot) const {
  return writeFileAtomically(fileOf(id, ".snapshot"), snapshot);
}

void DataFolder::remove(const std::string& id) const {
  std::error_code ignored;
  fs::remove(fileOf(id, ".snapshot"), ignored);
  fs::remove(fileOf(id, ".json"), ignored);
}

std::vector<DataFolder::Loaded> DataFolder::loadAll(std::vector<std::string>& problems) const {
  std::vector<Loaded> all;
  if (!isKept()) {
    return all;
  }
  std::error_code error;
  std::vector<std::string> ids;
  for (const auto& entry : fs::directory_iterator(fs::path(folder_) / "simulations", error)) {
    if (entry.path().extension() == ".snapshot") {
      ids.push_back(entry.path().stem().string());
    }
  }
  std::sort(ids.begin(), ids.end());
  DiskFileProvider files(SIZE_MAX);
  for (const std::string& id : ids) {
    auto snapshot = files.read(fileOf(id, ".snapshot"));
    const auto text = files.read(fileOf(id, ".json"));
    if (!snapshot || !text) {
      problems.push_back("simulation '" + id + "' is not loaded: " + fileOf(id, snapshot ? ".json" : ".snapshot") +
                         " cannot be read");
      continue;
    }
    auto record = toRecord(id, *text);
    if (const auto* problem = std::get_if<std::string>(&record)) {
      problems.push_back("simulation '" + id + "' is not loaded: " + fileOf(id, ".json") + ": " + *problem);
      continue;
    }
    all.push_back({std::move(std::get<SimulationRecord>(record)), std::move(*snapshot)});
  }
  return all;
}

}  // namespace espalier::server
