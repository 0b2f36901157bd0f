#include "clients/espalier/sweep/run_pipe.h"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "clients/espalier/sweep/sweep.h"

namespace espalier::command {
namespace {

static_assert(std::endian::native == std::endian::little, "the pipe carries the bytes of this machine");

constexpr std::uint64_t kMostRows = 100'000'000;

template <typename Value>
bool read(std::vector<Value>& values) {
  return std::fread(values.data(), sizeof(Value), values.size(), stdin) == values.size();
}

bool write(const void* bytes, std::size_t size) {
  return std::fwrite(bytes, 1, size, stdout) == size;
}

}  // namespace

bool servePipe(SweptModel& model, unsigned workers) {
  std::vector<std::string> names;
  for (const SweepParameter& parameter : model.plan().parameters) {
    names.push_back(parameter.name);
  }
  const nlohmann::json header = {
      {"parameters", names}, {"measures", model.measureColumns()}, {"seed", model.plan().seed}};
  const std::string line = header.dump() + "\n";
  RunPool pool(model, workers);
  if (!write(line.data(), line.size()) || std::fflush(stdout) != 0) {
    return false;
  }
  while (true) {
    std::vector<std::uint64_t> head(2);
    const std::size_t headBytes = head.size() * sizeof(head.front());
    const std::size_t found = std::fread(head.data(), 1, headBytes, stdin);
    if (found == 0) {
      return true;
    }
    if (found != headBytes || head[0] > kMostRows) {
      return false;
    }
    RunTable table{.values = {}, .seeds = {}, .columns = names.size()};
    table.values.resize(head[0] * names.size());
    table.seeds.assign(head[0], model.plan().seed);
    if (!read(table.values) || (head[1] != 0 && !read(table.seeds))) {
      return false;
    }
    const std::vector<RunOutcome> outcomes = pool.run(table);
    nlohmann::json errors = nlohmann::json::array();
    nlohmann::json warnings = nlohmann::json::array();
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      if (!write(outcomes[i].values.data(), outcomes[i].values.size() * sizeof(double))) {
        return false;
      }
      if (!outcomes[i].error.empty()) {
        errors.push_back({i, outcomes[i].error});
      }
      if (!outcomes[i].warning.empty()) {
        warnings.push_back({i, outcomes[i].warning});
      }
    }
    const nlohmann::json remarks = {{"failures", errors}, {"warnings", warnings}};
    const std::string text = remarks.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    const std::uint64_t size = text.size();
    if (!write(&size, sizeof size) || !write(text.data(), text.size()) || std::fflush(stdout) != 0) {
      return false;
    }
  }
}

}  // namespace espalier::command
