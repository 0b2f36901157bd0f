#include "clients/espalier/world_file.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "clients/espalier/json_file.h"
#include "clients/espalier/messages.h"
#include "protocol/codec.h"
#include "protocol/json_writer.h"
#include "server/remote/translation/translate.h"

namespace espalier::command {
namespace fs = std::filesystem;

namespace {

/// Replaces the name of the table of weather by its text. False: an error was printed.
bool embedWeather(protocol::WorldRecord& record, const std::string& file, core::FileProvider& files) {
  if (record.weather.empty()) {
    return true;
  }
  const std::string table = (fs::path(file).parent_path() / record.weather).string();
  std::optional<std::string> text = files.read(table);
  if (!text) {
    printError(file + ": there is no table of weather '" + table + "': check 'weather'");
    return false;
  }
  if (text->empty()) {  // which would mean no weather
    printError(file + ": the table of weather '" + table + "' is empty: check 'weather'");
    return false;
  }
  record.weather = std::move(*text);
  return true;
}

}  // namespace

std::string worldFileOf(const ModelOptions& options) {
  std::error_code error;
  const fs::path inside = fs::path(options.model) / kWorldFile;
  return fs::is_directory(options.model, error) && fs::is_regular_file(inside, error) ? inside.string() : std::string();
}

bool hasWorld(const ModelOptions& options, const std::string& file) {
  return !options.world.empty() || !options.stepDuration.empty() || !file.empty();
}

std::optional<protocol::WorldRecord> completeRecord(protocol::WorldRecord record, const std::string& file,
                                                    const ModelOptions& options, core::FileProvider& files) {
  if (!options.stepDuration.empty()) {
    record.stepDurationDays = *protocol::daysOfDuration(options.stepDuration);
  }
  return embedWeather(record, file, files) ? std::optional(std::move(record)) : std::nullopt;
}

std::optional<protocol::WorldRecord> readWorld(const ModelOptions& options, const std::string& file,
                                               core::FileProvider& files) {
  const std::string& chosen = options.world.empty() ? file : options.world;
  if (chosen.empty()) {
    return completeRecord({}, chosen, options, files);
  }
  auto record = decodeJsonFile(chosen, "world file", files, protocol::decodeWorld);
  return record ? completeRecord(std::move(*record), chosen, options, files) : std::nullopt;
}

std::optional<turtle::World> loadWorld(const ModelOptions& options, const std::string& file,
                                       core::FileProvider& files) {
  const auto record = readWorld(options, file, files);
  return record ? worldOf(*record, options.world.empty() ? file : options.world) : std::nullopt;
}

std::string worldText(const protocol::WorldRecord& record) {
  protocol::JsonWriter text;
  text.beginObject();
  protocol::write(text, record);
  return text.endObject().take();
}

std::optional<ChosenWorld> chooseWorld(const ModelOptions& options, const std::string& file,
                                       core::FileProvider& files) {
  const auto record = readWorld(options, file, files);
  auto world = record ? worldOf(*record, options.world.empty() ? file : options.world) : std::nullopt;
  if (!world) {
    return std::nullopt;
  }
  return ChosenWorld{std::move(*world), hasWorld(options, file) ? worldText(*record) : std::string()};
}

std::optional<turtle::World> completeWorld(protocol::WorldRecord record, const std::string& file,
                                           const ModelOptions& options, core::FileProvider& files) {
  const auto complete = completeRecord(std::move(record), file, options, files);
  return complete ? worldOf(*complete, file) : std::nullopt;
}

std::optional<turtle::World> worldOf(const protocol::WorldRecord& record, const std::string& file) {
  auto world = server::toWorld(record);
  if (!world) {
    printError(file + ": " + world.error());
    return std::nullopt;
  }
  return std::move(*world);
}

}  // namespace espalier::command
