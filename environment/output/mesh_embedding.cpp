#include "environment/output/mesh_embedding.h"

#include <nlohmann/json.hpp>

#include "environment/base/published_text.h"
#include "environment/obstacles/obstacle_mesh.h"

namespace espalier::environment {

std::optional<core::Diagnostic> embedMeshFile(EnvironmentEntry& entry, const std::string& file,
                                              core::FileProvider& files) {
  nlohmann::json configuration = nlohmann::json::parse(entry.configuration, nullptr, false);
  const auto named = configuration.is_object() ? configuration.find("meshFile") : configuration.end();
  if (!configuration.is_object() || named == configuration.end() || !named->is_string()) {
    return std::nullopt;
  }
  const std::string name = besideFile(file, named->get<std::string>());
  const auto failed = [&](const std::string& message) {
    core::Diagnostic diagnostic;
    diagnostic.message = file + ": the mesh file '" + name + "' of the environment '" + entry.name + "': " + message;
    diagnostic.hint = "an .obj, .glb or .gltf file, looked for beside the configuration";
    return diagnostic;
  };
  const auto bytes = files.read(name);
  if (!bytes) {
    return failed("it cannot be read");
  }
  const auto read = readMesh(name, *bytes);
  if (!read) {
    return failed(read.error());
  }
  configuration.erase(named);
  auto& vertices = configuration["vertices"] = nlohmann::json::array();
  for (const core::Vec3& vertex : read->vertices) {
    vertices.push_back({vertex.x, vertex.y, vertex.z});
  }
  auto& triangles = configuration["triangles"] = nlohmann::json::array();
  for (const auto& triangle : read->triangles) {
    triangles.push_back(triangle);
  }
  entry.configuration = configuration.dump();
  return std::nullopt;
}

}  // namespace espalier::environment
