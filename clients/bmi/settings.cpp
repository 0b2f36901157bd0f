#include "clients/bmi/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "clients/bmi/espalier_bmi.h"
#include "server/remote/disk_files.h"

namespace espalier::bmi {
namespace {

using Json = nlohmann::json;

struct Key {
  const char* name;
  const char* what;
  bool (*isRight)(const Json& value);
};

bool isText(const Json& value) {
  return value.is_string();
}

bool isNatural(const Json& value) {
  return value.is_number_unsigned();
}

bool isListOfNames(const Json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), isText);
}

const std::array<Key, 10> kKeys{{
    {"derivationLength", "a whole number from 0 on", isNatural},
    {"environment", "a name, an object, or a list of them",
     [](const Json& value) { return value.is_string() || value.is_object() || value.is_array(); }},
    {"gallery", "the name of a model of the gallery", isText},
    {"inputs", "a list of names", isListOfNames},
    {"model", "the name of a file or folder beside the configuration", isText},
    {"outputs", "a list of names", isListOfNames},
    {"parameters", "an object with a value for each name", [](const Json& value) { return value.is_object(); }},
    // of the Python model, which starts a server; this one is in the process
    {"program", "the path of the program espalier", isText},
    {"seed", "a whole number from 0 on", isNatural},
    {"stepDurationDays", "a number above 0",
     [](const Json& value) {
       return value.is_number() && value.get<double>() > 0.0 && std::isfinite(value.get<double>());
     }},
}};

Json readObject(const std::string& file) {
  server::DiskFileProvider files;
  const std::optional<std::string> text = files.read(file);
  if (!text) {
    throw BmiError(file + " cannot be read: Initialize takes the name of a configuration file.");
  }
  Json read = Json::parse(*text, nullptr, false);
  if (read.is_discarded()) {
    throw BmiError(file + " cannot be read as JSON: Initialize takes the name of a configuration file.");
  }
  if (!read.is_object()) {
    throw BmiError(file + " is no JSON object.");
  }
  return read;
}

void checkKeys(const Json& read, const std::string& file) {
  for (const auto& [name, value] : read.items()) {
    const auto* const key =
        std::find_if(kKeys.begin(), kKeys.end(), [&wanted = name](const Key& each) { return each.name == wanted; });
    if (key == kKeys.end()) {
      std::string known;
      for (const Key& each : kKeys) {
        known += (known.empty() ? "" : ", ") + std::string(each.name);
      }
      throw BmiError(file + ": '" + name + "' is not known. Keys: " + known + ".");
    }
    if (!value.is_null() && !key->isRight(value)) {
      throw BmiError(file + ": '" + name + "' is " + key->what + ", not " + value.dump() + ".");
    }
  }
}

}  // namespace

Settings readSettings(const std::string& file) {
  Json read = readObject(file);
  checkKeys(read, file);
  const auto has = [&read](const char* key) { return read.contains(key) && !read[key].is_null(); };
  if (has("model") == has("gallery")) {
    throw BmiError(file + " needs either 'model', a file or folder beside it, or 'gallery', a name.");
  }
  Settings settings;
  settings.file = file;
  settings.isGallery = has("gallery");
  settings.model = settings.isGallery
                       ? read["gallery"].get<std::string>()
                       : (std::filesystem::path(file).parent_path() / read["model"].get<std::string>()).string();
  settings.environment = has("environment") ? read["environment"].dump() : "";
  settings.seed = has("seed") ? read["seed"].get<std::uint64_t>() : 1;
  if (has("derivationLength")) {
    settings.derivationLength = read["derivationLength"].get<std::uint64_t>();
  }
  if (has("stepDurationDays")) {
    settings.stepDurationDays = read["stepDurationDays"].get<double>();
  }
  settings.outputs =
      has("outputs") ? read["outputs"].get<std::vector<std::string>>() : std::vector<std::string>{"modules", "height"};
  settings.inputs = has("inputs") ? read["inputs"].get<std::vector<std::string>>() : std::vector<std::string>{};
  const Json parameters = has("parameters") ? read["parameters"] : Json::object();
  for (const auto& [name, value] : parameters.items()) {
    settings.parameters.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
  }
  for (const std::string& name : settings.inputs) {
    const auto value = parameters.find(name);
    if (value == parameters.end() || !value->is_number() || !std::isfinite(value->get<double>())) {
      throw BmiError(file + ": the input '" + name + "' needs a value at the start, in 'parameters': a number.");
    }
    settings.inputValues.push_back(value->get<double>());
  }
  return settings;
}

}  // namespace espalier::bmi
