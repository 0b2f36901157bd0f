// Wrong configurations of every process: what is said about them. A process is made, opened and asked; one of the three
// has to say the words.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/environment/query_builder.h"

namespace espalier::environment {
namespace {

struct BadConfiguration {
  std::string name;
  std::string configuration;
  std::string said;
  std::vector<double> parameters{1.0, 1.0, 1.0};  // of the query
};

std::vector<BadConfiguration> badConfigurations() {
  return {
      // misspelt keys and wrong types
      {"honda", R"({"raduis":0.5})", "unknown key 'raduis'"},
      {"honda", R"({"radius":"0.5 cm"})", "'radius' must be a number, found the text '0.5 cm'"},
      {"honda", R"({"radius":-0.5})", "'radius' must be at least 0, found -0.5"},
      {"honda", R"({"radius":1,"radius":2})", "has the key 'radius' twice"},
      {"honda", R"({"radius":1e999})", "number overflow parsing '1e999'"},
      {"honda", R"({"plane":"zx"})", "'plane' must be one of 'xz', 'xy', 'yz', found 'zx'"},
      {"ecosystem", R"({"vigour":true})", "unknown key 'vigour'"},
      {"ecosystem", R"({"vigor":1})", "'vigor' must be true or false, found the number 1"},
      {"height", R"({"unit":"cm"})", "unknown key 'unit'"},
      {"density", R"({"plane":"zx"})", "'plane' must be one of"},
      {"density", R"({"exact":"yes"})", "'exact' must be true or false"},
      {"constant", R"({"values":[null]})", "'values[0]' must be a number, found null"},
      // empty grids, grids that are too large, boxes without an extent
      {"density3d", R"({"gridSize":[0,1,1]})", "'gridSize[0]' must be between 1 and 1048576, found 0"},
      {"density3d", R"({"gridSize":[2,2]})", "'gridSize' must be a list of 3 numbers, found 2"},
      {"density3d", R"({"range":[1,0,1]})", "'range[1]' must be greater than 0, found 0"},
      {"clover", R"({"gridSize":[512,0]})", "'gridSize[1]' must be between 1 and 8192, found 0"},
      {"clover", R"({"range":[-1,1]})", "'range[0]' must be greater than 0, found -1"},
      {"clover", R"({"lightMap":[[]]})", "'lightMap[0]' must be a list of at least 1 numbers, found 0"},
      {"clover", R"({"lightMap":[[1,2],[3]]})", "'lightMap[1]' must have 2 numbers as the row before, found 1"},
      {"clover", R"({"lightMap":[[256]]})", "'lightMap[0][0]' must be between 0 and 255, found 256"},
      {"ornament", R"({"secondMap":[[1],[3,4]]})", "'secondMap[1]' must have 1 numbers as the row before, found 2"},
      {"ornament", R"({"transmittance":1})", "unknown key 'transmittance'"},
      {"meadow", R"({"radius":-2})", "'radius' must be greater than 0, found -2"},
      {"meadow", R"({"lightMap":[[1,2],[3]]})", "'lightMap[1]' must have 2 numbers"},
      {"shadow", R"({"gridSize":1})", "'gridSize' must be between 2 and 1000, found 1"},
      {"shadow", R"({"gridSpan":0})", "'gridSpan' must be greater than 0, found 0"},
      {"shadow", R"({"shadowWeight":1.5})", "'shadowWeight' must be between 0 and 1, found 1.5"},
      {"soil", R"({"domainSize":[0,1,1]})", "'domainSize[0]' must be greater than 0, found 0"},
      {"soil", R"({"gridSize":[4096,4096,4096]})", "a field of 68719476736 cells is larger than 67108864 cells"},
      {"soil", R"({"concentration":[[1,2],[3]]})", "'concentration[1]' must have 2 numbers, found 1"},
      {"soil", R"({"concentration":[[1],[3]],"sliceCount":3})", "which are not 3 slices of equal size"},
      {"soil", R"({"concentration":[[1]],"gridSize":[2,2,2]})", "both 'concentration' and 'gridSize' are given"},
      {"soil", R"({"concentrationRange":[1,1]})", "'concentrationRange' must be a smaller and a larger number"},
      {"soil", R"({"obstacleMap":[[1,0]]})", "'obstacleMap[0]' must have 1 numbers, found 2"},
      {"soil", R"({"layerThicknesses":[1]})", "there are 1 layer thicknesses and 0 geotropic angles"},
      {"soil", R"({"obstacleScene":"sphere"})", "'obstacleScene', line 1"},
      {"emission", R"({"cellSize":0})", "'cellSize' must be greater than 0, found 0"},
      {"emission", R"({"gridSize":[1,1,0]})", "'gridSize[2]' must be between 1 and 4096, found 0"},
      // light
      {"chiba", R"({"radius":-1})", "'radius' must be at least 0, found -1"},
      {"chiba", R"({"transmittance":1.5})", "'transmittance' must be between 0 and 1, found 1.5"},
      {"chiba", R"({"sources":[[0,0,0,1]]})", "'sources[0]' has a direction of no length"},
      {"chiba", R"({"sources":[[0,1,0,1],[1,1,0,-1]]})", "'sources[1]' has a negative weight"},
      {"chiba", R"({"sources":[[0,1,0,0]]})", "'sources' have the weight 0 together, so there is no light"},
      {"takenaka", R"({"sources":[[0,9,0,-1]]})", "'sources[0]' has a negative weight"},
      {"takenaka", R"({"sources":[[0,9,0]]})", "'sources[0]' must be a list of 4 numbers, found 3"},
      {"takenaka", R"({"parameterS":0.5})", "'parameterS' is too small for the 'transmittance'"},
      // obstacles
      {"obstacles", R"({"spheres":[[0,0,0,-1]]})", "'spheres[0]' has a negative radius"},
      {"obstacles", R"({"capsules":[[0,0,0,1,0,0,-0.5]]})", "'capsules[0]' has a negative radius"},
      {"obstacles", R"({"boxes":[[1,1,1,0,0,0]]})", "'boxes[0]' has a first corner beyond its second"},
      {"obstacles", R"({"planes":[[0,0,0,0,0,0]]})", "'planes[0]' has a normal of no length"},
      {"obstacles", R"({"vertices":[[0,0,null]],"triangles":[[0,0,0]]})",
       "'vertices[0][2]' must be a number, found null"},
      {"obstacles", R"({"vertices":[[0,0,0]],"triangles":[[0,0,1]]})", "has a corner that is none of its 1 vertices"},
      {"obstacles", R"({"vertices":[[0,0,0]]})", "'triangles' has no triangles"},
      {"obstacles", R"({"mesh":"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"})",
       "'mesh': line 1: a vertex has the coordinate 'nan', which is no finite number"},
      {"obstacles", R"({"mesh":"v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n"})",
       "line 2: a vertex has fewer than three coordinates"},
      {"obstacles", R"({"mesh":"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"})", "a face has the vertex 9 of 3"},
      {"obstacles", R"({"mesh":"rock.obj"})", "'mesh': it has no triangles"},
      {"obstacles", R"({"scene":"sphere 1\nsphere -1"})",
       "'scene', line 2: 'sphere' needs a radius that is not negative"},
      {"obstacles", R"({"heightField":[[1,2],[3,4,5]],"heightFieldExtent":[0,0,1,1]})",
       "at least 2 rows of one length"},
      {"obstacles", R"({"heightField":[[1,2],[3,4]]})", "'heightFieldExtent' must be smallest x"},
      {"obstacles", R"({"heightFieldExtent":[0,0,1,1]})", "'heightFieldExtent' is given without a 'heightField'"},
      {"arvo", R"({"surfaceDistance":-1})", "'surfaceDistance' must be at least 0, found -1"},
      {"arvo", R"({"surfaceDistance":2})", "'surfaceDistance' is larger than 'maxSurfaceDistance'"},
      {"arvo", R"({"spheres":[[0,0,0]]})", "'spheres[0]' must be a list of 4 numbers, found 3"},
      // direction fields
      {"gravity", R"({"direction":[0,0,0]})", "'direction' must be three numbers that are not all 0"},
      {"wind", R"({"direction":[0,0,0]})", "'direction' must be three numbers that are not all 0"},
      {"wind", R"({"profile":"table","heights":[1,0],"speeds":[1,2]})", "'heights' must be ascending"},
      {"wind", R"({"profile":"logarithmic","referenceHeight":0.05})", "'referenceHeight' must be above"},
      {"attractors", "", "Environment 'attractors' has no attractors"},
      {"attractors", R"({"points":[[0,0,0]]})", "'points[0]' must be a list of 4 numbers, found 3"},
      // fields of fields
      {"multiple", R"({"fields":[{"type":"honda","radius":-1}]})",
       "fields[0]: environment process 'honda': 'radius' must"},
      {"multiple", R"({"fields":[{"type":"chibba"}]})", "Did you mean 'chiba'?"},
      {"multiple", R"({"fields":[{"type":"multiple"}]})", "a field cannot be 'multiple' itself"},
      {"multiple", "", "has no field 1"},
      // processes of Espalier's own
      {"colonization", "", "Environment 'colonization' has no markers"},
      {"colonization", R"({"markerCount":1,"markerBox":[1,0,0,0,1,1]})", "'markerBox' has a first corner beyond"},
      {"crowding", R"({"extent":[0,1,0]})", "'extent' is not a smallest and a largest number"},
      {"crowding", R"({"periodic":true,"extent":[0,1,0,1]})", "a zone whose radius is more than 50 times", {1e9}},
      {"light-voxels", R"({"gridSize":[0,1,1]})", "'gridSize[0]' must be between 1 and 4096, found 0"},
      {"light", R"({"directions":1})", "'directions' must be between 8 and 65536, found 1"},
      {"soil-water", R"({"layers":[[1,0.4,0.1,1,2,1]]})", "layers[0] has a residual water content"},
  };
}

/// What making, opening and asking the process says.
std::string saidBy(const BadConfiguration& bad) {
  auto made = makeProcess(bad.name, bad.configuration);
  if (const auto* problems = std::get_if<std::vector<core::Diagnostic>>(&made)) {
    std::string text;
    for (const core::Diagnostic& problem : *problems) {
      text += problem.message + "\n" + problem.hint + "\n";
      EXPECT_FALSE(problem.message.empty());
      EXPECT_NE(problem.message.find(bad.name), std::string::npos) << problem.message;
    }
    return text;
  }
  const auto& process = std::get<std::unique_ptr<turtle::EnvironmentProcess>>(made);
  if (const auto error = process->open({})) {
    return error->message;
  }
  QueryBuilder builder;
  builder.add({0.5, 0.5, 0.5}, bad.parameters);
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  const auto error = process->step(builder.batch(), replies);
  return error ? error->message : "nothing";
}

TEST(BadConfiguration, IsNamedWithTheProcessTheKeyAndWhatIsExpected) {
  for (const BadConfiguration& bad : badConfigurations()) {
    const std::string said = saidBy(bad);
    EXPECT_NE(said.find(bad.said), std::string::npos) << bad.name << " " << bad.configuration << " says: " << said;
  }
}

TEST(BadConfiguration, IsTriedOnEveryProcess) {
  std::set<std::string> tried;
  for (const BadConfiguration& bad : badConfigurations()) {
    tried.insert(bad.name);
  }
  for (const std::string& name : processNames()) {
    EXPECT_TRUE(tried.contains(name)) << name;
  }
}

TEST(ConfigurationSchema, HasEveryKeyThatIsReadAndNoOther) {
  for (const std::string& name : processNames()) {
    const auto schema = nlohmann::json::parse(configurationSchema(name));
    for (const auto& [key, property] : schema["properties"].items()) {
      EXPECT_FALSE(property["description"].get<std::string>().empty()) << name << " " << key;
      EXPECT_TRUE(property.contains("default")) << name << " " << key;
      // what no key holds is refused by its name: the key is read
      nlohmann::json wrong = {{key, {{"an", "object"}}}};
      auto made = makeProcess(name, wrong.dump());
      const auto* problems = std::get_if<std::vector<core::Diagnostic>>(&made);
      ASSERT_NE(problems, nullptr) << name << " " << key;
      EXPECT_NE(problems->front().message.find("'" + key + "' must be"), std::string::npos)
          << problems->front().message;
      // its default is a value that it takes
      made = makeProcess(name, nlohmann::json{{key, property["default"]}}.dump());
      problems = std::get_if<std::vector<core::Diagnostic>>(&made);
      EXPECT_EQ(problems, nullptr) << name << " " << key << ": " << (problems ? problems->front().message : "");
    }
    auto made = makeProcess(name, R"({"noSuchKey":1})");
    const auto* problems = std::get_if<std::vector<core::Diagnostic>>(&made);
    ASSERT_NE(problems, nullptr) << name;
    EXPECT_NE(problems->front().message.find("unknown key 'noSuchKey'"), std::string::npos);
  }
}

}  // namespace
}  // namespace espalier::environment
