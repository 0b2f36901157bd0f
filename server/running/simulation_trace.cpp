#include "server/running/simulation_trace.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

fs::path pathOf(const std::string& folder, const std::string& id, std::uint64_t number) {
  return fs::path(folder) / (id + "-" + std::to_string(number) + ".trace.zst");
}

}  // namespace

std::vector<StoredTrace> SimulationTrace::list(const std::string& folder, const std::string& id) {
  std::vector<StoredTrace> traces;
  std::error_code error;
  // numbers are given without gaps
  for (std::uint64_t number = 1; !folder.empty(); ++number) {
    const std::uint64_t bytes = fs::file_size(pathOf(folder, id, number), error);
    if (error) {
      break;
    }
    traces.push_back({number, bytes});
  }
  return traces;
}

std::optional<std::string> SimulationTrace::read(const std::string& folder, const std::string& id, std::uint64_t number,
                                                 std::uint64_t bound) {
  std::error_code error;
  const fs::path path = pathOf(folder, id, number);
  if (folder.empty() || fs::file_size(path, error) > bound || error) {
    return std::nullopt;
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  return file.is_open() && !file.bad() ? std::optional(std::move(bytes)) : std::nullopt;
}

tl::expected<std::unique_ptr<SimulationTrace>, std::string> SimulationTrace::create(const std::string& folder,
                                                                                    const std::string& id) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return tl::unexpected("cannot make the folder of traces '" + folder + "': " + error.message() + ".");
  }
  std::uint64_t number = 1;
  while (fs::exists(pathOf(folder, id, number), error)) {
    ++number;
  }
  const fs::path name = pathOf(folder, id, number);
  auto file = TraceFile::create(name.string());
  if (!file) {
    return tl::unexpected(std::move(file.error()));
  }
  return std::unique_ptr<SimulationTrace>(new SimulationTrace(std::move(*file), name.string()));
}

SimulationTrace::~SimulationTrace() {
  if (!hasBegun_) {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
}

std::string SimulationTrace::problem() const {
  return file_->problem().empty() ? std::string()
                                  : "The trace ended, because the data folder does not take more of it: make room on "
                                    "the disk, then begin another one with simulation.trace.";
}

void SimulationTrace::removeAll(const std::string& folder, const std::string& id) {
  std::error_code ignored;
  for (const StoredTrace& trace : list(folder, id)) {
    fs::remove(pathOf(folder, id, trace.number), ignored);
  }
}

}  // namespace espalier::server
