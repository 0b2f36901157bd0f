#include "protocol/decoding/forest_members.h"

#include <gtest/gtest.h>

#include "protocol/codec.h"
#include "tests/protocol/decoding/problem.h"

namespace espalier::protocol::forest_members_test {
namespace {

Payload params(const std::string& json) {
  return decodeMessage(R"({"jsonrpc":"2.0","id":1,"method":"m","params":)" + json + "}").value().payload;
}

TEST(ForestMembers, ACreateHasModelsByNameAndPlantsThatChoose) {
  const auto create =
      decodeCreateParams(params(
                             R"({"models":[{"name":"oak","source":"x"},{"name":"ash","gallery":"lilac","colour":-9}],
          "plants":[{"position":[1,2,3],"model":"ash","heading":[0,0,2],"turn":90,"name":"n","colour":4}],
          "seeds":{"maximumPlants":7,"spacing":0.5,"ground":-1,"area":[[0,0,0],[1,2,3]]}})"))
          .value();
  ASSERT_EQ(create.models.size(), 2U);
  EXPECT_EQ(create.models[0].model.model.source, "x");
  EXPECT_EQ(create.models[1].model.model.gallery, "lilac");
  EXPECT_EQ(create.models[1].colour, -9);
  EXPECT_EQ(create.plants.at(0).model, "ash");
  EXPECT_EQ(create.plants[0].turnDegrees, 90.0);
  EXPECT_EQ((*create.plants[0].heading)[2], 2.0);
  EXPECT_EQ(create.seeds.maximumPlants, 7U);
  EXPECT_EQ((*create.seeds.area)[1][2], 3.0);
}

TEST(ForestMembers, NameWhatIsWrong) {
  const auto created = [](const std::string& json) { return problem(decodeCreateParams(params(json))); };
  EXPECT_EQ(created(R"({"model":"a","models":[{"name":"b","source":"x"}]})"),
            "params.models: give \"model\" or \"models\", not both");
  EXPECT_EQ(created(R"({"models":[]})"), "params.models: expected at least one model");
  EXPECT_EQ(created(R"({"models":[{"name":"b","source":"x"},{"name":"b","source":"x"}]})"),
            "params.models[1].name: there are two models 'b'; give each a name of its own");
  EXPECT_EQ(created(R"({"models":[{"name":"b","source":"x"}],"plants":[{"position":[0,0,0],"model":"c"}]})"),
            "params.plants[0].model: there is no model 'c'. There are b");
  EXPECT_EQ(created(R"({"model":"a","plants":[{"position":[0,0,0],"model":"c"}]})"),
            "params.plants[0].model: the simulation has one model without a name; leave this out, or give \"models\"");
  EXPECT_EQ(created(R"({"model":"a","plants":[{"position":[0,0,0],"heading":[0,0,0]}]})"),
            "params.plants[0].heading: a heading of length 0 has no direction");
  EXPECT_EQ(created(R"({"model":"a","seeds":{"spacing":-1}})"),
            "params.seeds.spacing: expected a length of at least 0, found -1");
  EXPECT_EQ(created(R"({"model":"a","seeds":{"area":[[0,0,0]]}})"),
            "params.seeds.area: expected two corners of three numbers, found an array");
}

TEST(ForestMembers, AForestFileHasNoKeysThatAreNotKnown) {
  const auto read = [](const std::string& json) { return problem(decodeForestParams(params(json))); };
  EXPECT_EQ(read(R"({"models":[{"name":"b","file":"x.l"}],"plants":[{"position":[0,0,0]}],"environment":"a.e"})"),
            "(accepted)");
  EXPECT_EQ(read(R"({"model":"x.l"})"),
            "params.model: this key is not known; did you mean 'models'? There are models, plants, seeds, environment, "
            "derivationLength, seed, world");
  EXPECT_EQ(read(R"({"up":"z"})"),
            "params.up: this key is not known; there are models, plants, seeds, environment, derivationLength, seed, "
            "world");
  EXPECT_EQ(read(R"({"models":[{"name":"b"}],"plants":[{"position":[0,0,0]}]})"),
            "params.models[0].file: expected the name of a .l file or of a model folder");
  EXPECT_EQ(read(R"({"models":[{"name":"b","file":"x.l"}]})"),
            "params.plants: expected at least one plant, such as {\"position\": [0, 0, 0]}");
  EXPECT_EQ(
      read(R"({"models":[{"name":"b","file":"x.l"}],"plants":[{"position":[0,0,0]}],"environment":3})"),
      "params.environment: expected the name of a file, or an environment such as {\"type\": \"honda\"}, or a list "
      "of them, found 3");
}

TEST(ForestMembers, AWorldFileNamesTheKeyOrTheVectorThatWasMeant) {
  const auto read = [](const std::string& json) { return problem(decodeWorld(params(json))); };
  const std::string keys = "lengthUnit, up, north, stepDuration, latitude, longitude, start, baseTemperature, weather";
  EXPECT_EQ(read(R"({"Up":[0,0,1]})"), "params.Up: this key is not known; did you mean 'up'? There are " + keys);
  EXPECT_EQ(read(R"({"latitud":49})"),
            "params.latitud: this key is not known; did you mean 'latitude'? There are " + keys);
  EXPECT_EQ(read(R"({"gravity":9.81})"), "params.gravity: this key is not known; there are " + keys);
  EXPECT_EQ(read(R"({"up":"z"})"), "params.up: expected three numbers such as [0, 0, 1], found \"z\"");
  EXPECT_EQ(read(R"({"north":"-x"})"), "params.north: expected three numbers such as [-1, 0, 0], found \"-x\"");
  EXPECT_EQ(read(R"({"up":"above"})"), "params.up: expected three numbers such as [0, 1, 0], found \"above\"");
}

TEST(ForestMembers, WhatIsWrittenIsReadAgain) {
  const auto create = decodeCreateParams(params(
                                             R"({"models":[{"name":"ash","source":"x"}],
          "plants":[{"position":[1,2,3],"model":"ash","heading":[0,0,2],"turn":90,"name":"n","colour":-4}],
          "seeds":{"maximumPlants":7,"spacing":0.5,"ground":-1,"area":[[0,0,0],[1,2,3]]}})"))
                          .value();
  JsonWriter writer;
  writer.beginObject().key("models").raw(R"([{"name":"ash","source":"x"}])");
  writePlants(writer, create.plants);
  writeSeeds(writer, create.seeds);
  const auto again = decodeCreateParams(params(writer.endObject().take())).value();
  EXPECT_EQ(again.plants.at(0).model, "ash");
  EXPECT_EQ(again.plants[0].colour, -4);
  EXPECT_EQ(again.plants[0].name, "n");
  EXPECT_EQ(again.plants[0].heading, create.plants[0].heading);
  EXPECT_EQ(again.seeds.area, create.seeds.area);
  EXPECT_EQ(again.seeds.maximumPlants, 7U);
}

}  // namespace
}  // namespace espalier::protocol::forest_members_test
