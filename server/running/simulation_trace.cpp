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

void removeFile(const fs::path& path, DiskRoom* room) {
  std::error_code error;
  const std::uint64_t bytes = fs::file_size(path, error);
  if (!error && fs::remove(path, error) && room != nullptr) {
    room->add(-static_cast<std::int64_t>(bytes));
  }
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

tl::expected<std::unique_ptr<SimulationTrace>, std::string> SimulationTrace::create(const TraceFolder& folder,
                                                                                    const std::string& id) {
  std::error_code error;
  fs::create_directories(folder.path, error);
  if (error) {
    return tl::unexpected("cannot make the folder of traces '" + folder.path + "': " + error.message() + ".");
  }
  std::uint64_t number = 1;
  while (fs::exists(pathOf(folder.path, id, number), error)) {
    ++number;
  }
  const fs::path name = pathOf(folder.path, id, number);
  auto file = TraceFile::create(name.string(), folder.room);
  if (!file) {
    return tl::unexpected(std::move(file.error()));
  }
  return std::unique_ptr<SimulationTrace>(new SimulationTrace(std::move(*file), name.string(), folder.room));
}

SimulationTrace::~SimulationTrace() {
  if (!hasBegun_) {
    close();
    removeFile(path_, room_);
  }
}

std::string SimulationTrace::problem() const {
  if (const DiskRoom* const room = file_->outOfRoom()) {
    return "The trace ended, because " + room->what() + " have " + std::to_string(room->used()) + " of " +
           std::to_string(room->bound()) + " bytes (limit " + std::string(room->limit()) +
           "): delete simulations with traces, then begin another one with simulation.trace.";
  }
  return file_->problem().empty() ? std::string()
                                  : "The trace ended, because the data folder does not take more of it: make room on "
                                    "the disk, then begin another one with simulation.trace.";
}

std::uint64_t SimulationTrace::bytesOf(const std::string& folder, const std::string& id) {
  std::uint64_t sum = 0;
  for (const StoredTrace& trace : list(folder, id)) {
    sum += trace.bytes;
  }
  return sum;
}

void SimulationTrace::removeAll(const TraceFolder& folder, const std::string& id) {
  for (const StoredTrace& trace : list(folder.path, id)) {
    removeFile(pathOf(folder.path, id, trace.number), folder.room);
  }
}

std::uint64_t SimulationTrace::bytesIn(const std::string& folder) {
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    const std::uint64_t bytes = entry->file_size(gone);
    sum += gone ? 0 : bytes;
  }
  return sum;
}

}  // namespace espalier::server
