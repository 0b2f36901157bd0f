#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

namespace espalier::environment {

/// A process with a configuration in which its queries matter to each other.
struct Candidate {
  std::string name;
  std::string configuration;
  std::size_t parameterCount;  // of a query, at most
};

inline void PrintTo(const Candidate& candidate, std::ostream* stream) {
  *stream << candidate.name << " " << candidate.configuration;
}

/// At least one of every process.
inline std::vector<Candidate> candidates() {
  return {
      {"arvo", R"({"spheres":[[5,5,5,3]],"planes":[[0,0,0,0,1,0]],"maxSurfaceDistance":3,"addObjects":true})", 7},
      {"arvo", R"({"spheres":[[5,5,5,3]],"boxes":[[0,0,0,9,1,9]],"compatible":true,"triesForSurface":8})", 7},
      {"attractors", R"({"points":[[1,2,3,4],[9,8,7,-2]]})", 4},
      {"chiba", R"({"radius":1,"sampleCount":8})", 4},
      {"chiba", R"({"radius":1,"sources":[[0,1,0,4],[1,1,0,3]],"estimateIntersectionArea":true,"beamRadius":0.5})", 4},
      {"clover", R"({"gridSize":[64,64],"range":[10,10],"position":[0,0]})", 2},
      {"colonization", R"({"markerCount":2000,"markerBox":[0,0,0,10,10,10],"occupancyRadius":0.4})", 5},
      {"constant", "", 2},
      {"crowding", R"({"samples":20,"leastShare":0.2,"deathProbability":0.5})", 5},
      {"crowding", R"({"extent":[0,10,0,10],"periodic":true,"siteQuality":[[1,0.5]],"competition":"largest"})", 5},
      {"density", "", 3},
      {"density", R"({"onePointValue":true,"returnVector":true})", 3},
      {"density3d", R"({"range":[10,10,10],"gridSize":[5,5,5]})", 1},
      {"ecosystem", "", 2},
      {"ecosystem", R"({"vigor":true,"threeDimensional":true})", 2},
      {"emission", R"({"gridSize":[5,5,5],"cellSize":2,"diffusivity":0.5,"decayRate":0.1,"border":"open"})", 4},
      {"gravity", "", 3},
      {"height", "", 1},
      {"honda", R"({"radius":1})", 2},
      {"light", R"({"sun":"direction","sunDirection":[1,2,0],"directions":32})", 4},
      {"light-voxels", R"({"gridSize":[10,10,10],"voxelSize":1,"position":[0,0,0],"zenithAngles":3})", 5},
      {"light-voxels", R"({"method":"shadow","gridSize":[10,10,10],"voxelSize":1,"position":[0,0,0]})", 4},
      {"meadow", R"({"gridSize":[16,16],"range":[10,10],"position":[0,0],"lightMap":[[0,255],[100,30]]})", 6},
      {"multiple",
       R"({"fields":[{"type":"soil","domainSize":[10,10,10],"gridSize":[4,4,1],"depletion":true},)"
       R"({"type":"chiba","radius":1}]})",
       3},
      {"obstacles",
       R"({"spheres":[[5,5,5,3]],"capsules":[[1,1,1,4,2,9,0.5]],"heightField":[[1,2],[0,1]],)"
       R"("heightFieldExtent":[0,0,10,10],"plants":"remembered"})",
       9},
      {"ornament", R"({"gridSize":[64,64],"range":[10,10],"position":[0,0]})", 2},
      {"shadow", R"({"gridSize":41,"gridSpan":20})", 4},
      {"soil",
       R"({"domainSize":[10,10,10],"gridSize":[6,5,1],"depletion":true,"diffusionSteps":3,)"
       R"("layerThicknesses":[3,4],"geotropicAngles":[20,60]})",
       6},
      {"soil",
       R"({"domainSize":[10,10,10],"concentration":[[1,2,3],[4,0,6],[1,1,1],[0.5,2,2]],"sliceCount":2,)"
       R"("obstacleMap":[[0,0,0],[0,1,0],[0,0,0],[0,0,0]],"sourceMap":[[1,0,0],[0,0,0],[0,0,0],[0,0,1]],)"
       R"("depletion":true,"diffusionSteps":2})",
       7},
      {"soil-water",
       R"({"gridSize":[4,5,3],"cellSize":[2.5,2,3.4],"position":[0,0,0],"spheres":[[5,5,5,2]],"acidity":true,)"
       R"("layers":[[3,0.05,0.4,2,1.6,0.2],[1,0.08,0.43,1,1.4,0.05]],"rain":[[0,0.01],[2,0]],)"
       R"("solutes":[[1,0.5,0.001,0.1,0.2,0.01]]})",
       9},
      {"takenaka", R"({"sources":[[0,100,0,1],[50,80,3,0.5]]})", 2},
      {"wind", R"({"profile":"power"})", 3},
  };
}

/// The name of a test of one of them.
inline std::string nameOf(const testing::TestParamInfo<Candidate>& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name + std::to_string(info.index);
}

}  // namespace espalier::environment
