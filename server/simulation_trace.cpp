#include "server/simulation_trace.h"

#include <filesystem>

namespace espalier::server {

std::variant<std::unique_ptr<SimulationTrace>, std::string> SimulationTrace::create(const std::string& folder,
                                                                                    const std::string& id) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return "cannot make the folder of traces '" + folder + "': " + error.message() + ".";
  }
  int number = 1;
  fs::path name;
  do {
    name = fs::path(folder) / (id + "-" + std::to_string(number++) + ".trace.zst");
  } while (fs::exists(name, error));
  auto file = TraceFile::create(name.string());
  if (auto* problem = std::get_if<std::string>(&file)) {
    return std::move(*problem);
  }
  return std::unique_ptr<SimulationTrace>(new SimulationTrace(std::move(std::get<std::unique_ptr<TraceFile>>(file))));
}

}  // namespace espalier::server
