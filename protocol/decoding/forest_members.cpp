#include "protocol/decoding/forest_members.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "protocol/codec.h"
#include "protocol/decoding/decode_payload.h"
#include "protocol/decoding/near_name.h"

namespace espalier::protocol {
namespace {

constexpr std::size_t kLongestForestNameBytes = 200;
constexpr std::int64_t kLargestColour = 1'000'000;

std::int64_t readColour(const Member& member) {
  return member.isAbsent() ? 0 : member.integer(-kLargestColour, kLargestColour);
}

bool hasModel(const std::vector<NamedModel>& models, const std::string& name) {
  return std::any_of(models.begin(), models.end(), [&](const NamedModel& model) { return model.name == name; });
}

std::string namesOf(const std::vector<NamedModel>& models) {
  std::string names;
  for (const NamedModel& model : models) {
    names += (names.empty() ? "" : ", ") + model.name;
  }
  return names;
}

template <std::size_t Count>
void requireAllKnown(const Member& list, const std::array<std::string_view, Count>& known) {
  if (!list.isAbsent()) {
    const std::size_t count = list.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      requireKnown(list.element(i), known);
    }
  }
}

}  // namespace

void requireKnown(const Member& object, std::span<const std::string_view> known) {
  object.requireObject();
  for (const auto& [name, value] : object.json().items()) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      std::string list;
      for (const std::string_view key : known) {
        list += (list.empty() ? "" : ", ") + std::string(key);
      }
      const std::string_view nearest = nearName(name, known);
      object[name].fail("this key is not known; " +
                        (nearest.empty() ? "there are " : "did you mean '" + std::string(nearest) + "'? There are ") +
                        list);
    }
    if (value.is_null()) {
      object[name].fail("null is no value; leave the key out for its default");
    }
  }
}

std::string readName(const Member& member) {
  const std::string& name = member.text();
  if (name.empty() || name.size() > kLongestForestNameBytes) {
    member.fail("expected a name of 1 to " + std::to_string(kLongestForestNameBytes) + " bytes, found " +
                std::to_string(name.size()) + " bytes");
  }
  return name;
}

std::array<double, 3> readVector(const Member& member) {
  if (member.arraySize() != 3) {
    member.failExpected("three numbers");
  }
  return {member.element(0).number(), member.element(1).number(), member.element(2).number()};
}

void readModels(const Member& params, const std::function<void(const Member& entry, ModelParams& model)>& readModel,
                std::vector<NamedModel>& models) {
  const Member list = params["models"];
  const std::size_t count = list.arraySize();
  if (count == 0) {
    list.fail("expected at least one model");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Member entry = list.element(i);
    entry.requireObject();
    NamedModel model;
    const Member name = entry["name"];
    model.name = readName(name);
    if (hasModel(models, model.name)) {
      name.fail("there are two models '" + model.name + "'; give each a name of its own");
    }
    model.colour = readColour(entry["colour"]);
    if (const Member file = entry["file"]; !file.isAbsent() && !readModel) {
      model.file = readName(file);
    } else if (readModel) {
      readModel(entry, model.model);
    } else {
      file.fail("expected the name of a .l file or of a model folder");
    }
    models.push_back(std::move(model));
  }
}

void readPlants(const Member& plants, const std::vector<NamedModel>& models, std::vector<PlantParams>& result) {
  if (plants.isAbsent()) {
    return;
  }
  const std::size_t count = plants.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Member entry = plants.element(i);
    entry.requireObject();
    PlantParams plant;
    plant.position = readVector(entry["position"]);
    if (const Member model = entry["model"]; !model.isAbsent()) {
      plant.model = model.text();
      if (!hasModel(models, plant.model)) {
        model.fail(models.empty() ? "the simulation has one model without a name; leave this out, or give \"models\""
                                  : "there is no model '" + plant.model + "'. There are " + namesOf(models));
      }
    }
    if (const Member heading = entry["heading"]; !heading.isAbsent()) {
      plant.heading = readVector(heading);
      const auto& [x, y, z] = *plant.heading;
      if (x == 0.0 && y == 0.0 && z == 0.0) {
        heading.fail("a heading of length 0 has no direction");
      }
    }
    if (const Member turn = entry["turn"]; !turn.isAbsent()) {
      plant.turnDegrees = turn.number();
    }
    if (const Member name = entry["name"]; !name.isAbsent()) {
      plant.name = readName(name);
    }
    plant.colour = readColour(entry["colour"]);
    result.push_back(std::move(plant));
  }
}

void readSeeds(const Member& member, SeedParams& seeds) {
  if (member.isAbsent()) {
    return;
  }
  member.requireObject();
  if (const Member most = member["maximumPlants"]; !most.isAbsent()) {
    seeds.maximumPlants = most.count();
  }
  if (const Member spacing = member["spacing"]; !spacing.isAbsent()) {
    seeds.spacing = spacing.number();
    if (seeds.spacing < 0.0) {
      spacing.failExpected("a length of at least 0");
    }
  }
  if (const Member ground = member["ground"]; !ground.isAbsent()) {
    seeds.ground = ground.number();
  }
  if (const Member area = member["area"]; !area.isAbsent()) {
    if (area.arraySize() != 2) {
      area.failExpected("two corners of three numbers");
    }
    seeds.area = {readVector(area.element(0)), readVector(area.element(1))};
  }
}

Expected<ForestParams> decodeForestParams(const Payload& payload) {
  return decodePayload<ForestParams>(payload, [](const Member& params, ForestParams& forest) {
    static constexpr std::array<std::string_view, 7> kForest{"models",           "plants", "seeds", "environment",
                                                             "derivationLength", "seed",   "world"};
    static constexpr std::array<std::string_view, 3> kModel{"name", "file", "colour"};
    static constexpr std::array<std::string_view, 6> kPlant{"model", "position", "heading", "turn", "name", "colour"};
    static constexpr std::array<std::string_view, 4> kSeeds{"maximumPlants", "spacing", "ground", "area"};
    requireKnown(params, kForest);
    requireAllKnown(params["models"], kModel);
    requireAllKnown(params["plants"], kPlant);
    if (const Member seeds = params["seeds"]; !seeds.isAbsent()) {
      requireKnown(seeds, kSeeds);
    }
    readModels(params, nullptr, forest.models);
    readPlants(params["plants"], forest.models, forest.plants);
    if (forest.plants.empty()) {
      params["plants"].fail("expected at least one plant, such as {\"position\": [0, 0, 0]}");
    }
    readSeeds(params["seeds"], forest.seeds);
    if (const Member environment = params["environment"]; environment.isText()) {
      forest.environmentFile = readName(environment);
    } else if (environment.isArray() || environment.isObject()) {
      forest.environmentJson = environment.dump();
    } else if (!environment.isAbsent()) {
      environment.failExpected(
          "the name of a file, or an environment such as {\"type\": \"honda\"}, or a list of them");
    }
    if (const Member length = params["derivationLength"]; !length.isAbsent()) {
      forest.derivationLength = length.count();
    }
    if (const Member seed = params["seed"]; !seed.isAbsent()) {
      forest.seed = seed.wide();
    }
    if (const Member world = params["world"]; !world.isAbsent()) {
      forest.world = readOwnWorld(world);
    }
  });
}

void writePlants(JsonWriter& writer, const std::vector<PlantParams>& plants) {
  writer.key("plants").beginArray();
  for (const PlantParams& plant : plants) {
    writer.beginObject().key("position").numbers(plant.position);
    if (plant.heading) {
      writer.key("heading").numbers(*plant.heading);
    }
    if (plant.turnDegrees != 0.0) {
      writer.key("turn").number(plant.turnDegrees);
    }
    if (!plant.model.empty()) {
      writer.key("model").text(plant.model);
    }
    if (!plant.name.empty()) {
      writer.key("name").text(plant.name);
    }
    if (plant.colour != 0) {
      writer.key("colour").number(static_cast<double>(plant.colour));
    }
    writer.endObject();
  }
  writer.endArray();
}

void writeSeeds(JsonWriter& writer, const SeedParams& seeds) {
  writer.key("seeds").beginObject();
  if (seeds.maximumPlants) {
    writer.key("maximumPlants").integer(*seeds.maximumPlants);
  }
  writer.key("spacing").number(seeds.spacing).key("ground").number(seeds.ground);
  if (seeds.area) {
    writer.key("area").beginArray().numbers((*seeds.area)[0]).numbers((*seeds.area)[1]).endArray();
  }
  writer.endObject();
}

}  // namespace espalier::protocol
