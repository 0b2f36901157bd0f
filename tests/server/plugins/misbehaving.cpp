// A plug-in in C++ that misbehaves in a step that its configuration names, as long as a file is there:
//   {"does": "throw", "in": 2, "while": "/path/of/a/file"}
// `does` is throw, throwNothing, hang, nan, fail or die. Otherwise it answers the number of steps that it has made, its
// state.

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "environment/plugin.h"

namespace {

struct Misbehaving {
  std::string does, file;
  std::uint64_t in = 0;
  std::uint64_t steps = 0;
};

// the text behind a key of a flat JSON object
std::string valueOf(const std::string& json, const std::string& key) {
  auto at = json.find("\"" + key + "\"");
  if (at == std::string::npos) {
    return {};
  }
  at = json.find_first_not_of(" \"", json.find(':', at) + 1);
  return json.substr(at, json.find_first_of("\",}", at) - at);
}

Misbehaving& of(void* instance) {
  return *static_cast<Misbehaving*>(instance);
}

void* create(const char* configuration, char*, std::size_t) {
  const std::string json = configuration;
  return new Misbehaving{.does = valueOf(json, "does"),
                         .file = valueOf(json, "while"),
                         .in = std::strtoull(valueOf(json, "in").c_str(), nullptr, 10)};
}

void destroy(void* instance) {
  delete static_cast<Misbehaving*>(instance);
}

int openSimulation(void* instance, const espalier_context*, char*, std::size_t) {
  of(instance).steps = 0;
  return 0;
}

int step(void* instance, const espalier_queries* queries, espalier_replies* replies, char* message, std::size_t size) {
  Misbehaving& self = of(instance);
  const bool misbehaves = queries->step + 1 == self.in && std::filesystem::exists(self.file);
  if (misbehaves && self.does == "fail") {
    std::snprintf(message, size, "it is not my day");
    return 1;
  }
  ++self.steps;
  if (misbehaves && self.does == "throw") {
    throw std::runtime_error("the well is dry");
  }
  if (misbehaves && self.does == "die") {
    std::abort();
  }
  if (misbehaves && self.does == "throwNothing") {
    throw 7;
  }
  while (misbehaves && self.does == "hang") {
    ::pause();
  }
  for (std::size_t i = 0; i < queries->count; ++i) {
    const std::uint64_t first = queries->parameter_offset[i];
    if (queries->parameter_offset[i + 1] > first) {
      replies->values[first] = misbehaves ? std::nan("") : static_cast<double>(self.steps);
      replies->is_set[first] = 1;
    }
  }
  return 0;
}

std::size_t save(void* instance, void* buffer, std::size_t capacity) {
  if (capacity >= sizeof(std::uint64_t)) {
    std::memcpy(buffer, &of(instance).steps, sizeof(std::uint64_t));
  }
  return sizeof(std::uint64_t);
}

int restore(void* instance, const void* state, std::size_t, char*, std::size_t) {
  std::memcpy(&of(instance).steps, state, sizeof(std::uint64_t));
  return 0;
}

}  // namespace

extern "C" const espalier_plugin* espalier_plugin_entry() {
  static const espalier_plugin table{.version = ESPALIER_PLUGIN_VERSION,
                                     .size = sizeof(espalier_plugin),
                                     .name = "misbehaving",
                                     .summary = "Misbehaves when it is told to.",
                                     .needs = 0,
                                     .is_stateful = 1,
                                     .input_count = 0,
                                     .output_count = 0,
                                     .inputs = nullptr,
                                     .outputs = nullptr,
                                     .create = create,
                                     .destroy = destroy,
                                     .open = openSimulation,
                                     .step = step,
                                     .tick = nullptr,
                                     .save = save,
                                     .restore = restore};
  return &table;
}
