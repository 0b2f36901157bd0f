#include "tests/benchmark/gallery_model.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "protocol/codec.h"
#include "protocol/envelope.h"
#include "server/remote/translation/translate.h"
#include "tests/support/disk_files.h"
#include "tests/support/model_environment.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

namespace fs = std::filesystem;

turtle::World worldOf(const fs::path& folder, core::FileProvider& files) {
  const auto text = files.read((folder / "world.json").string());
  if (!text) {
    return {};
  }
  const auto message = protocol::decodeMessage(R"({"jsonrpc":"2.0","method":"file","params":)" + *text + "}");
  if (!message) {
    throw std::runtime_error(message.error().error.message);
  }
  auto record = protocol::decodeWorld(message->payload);
  if (!record) {
    throw std::runtime_error(record.error().message);
  }
  if (!record->weather.empty()) {
    record->weather = files.read((folder / record->weather).string()).value_or("");
  }
  auto world = server::toWorld(*record);
  if (!world) {
    throw std::runtime_error(world.error());
  }
  return std::move(*world);
}

}  // namespace

std::vector<std::string> galleryModels() {
  std::vector<std::string> models;
  for (const auto& folder : fs::directory_iterator(sourceFolder() + "/clients/gallery")) {
    const fs::path model = folder.path() / (folder.path().filename().string() + ".l");
    if (fs::exists(model)) {
      models.push_back(model.string());
    }
  }
  std::sort(models.begin(), models.end());
  return models;
}

simulation::Simulation simulationOf(const std::shared_ptr<const language::Program>& program,
                                    const std::string& modelFile) {
  test::DiskFiles files;
  simulation::SimulationOptions options;
  options.world = worldOf(fs::path(modelFile).parent_path(), files);
  return {program, {turtle::PlantPlacement{}}, test::environmentBeside(modelFile, files), std::move(options)};
}

}  // namespace espalier::benchmarking
