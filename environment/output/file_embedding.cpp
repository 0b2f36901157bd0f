#include "environment/output/file_embedding.h"

#include "environment/output/field_embedding.h"
#include "environment/output/mesh_embedding.h"
#include "environment/output/point_embedding.h"

namespace espalier::environment {

std::optional<core::Diagnostic> embedFiles(EnvironmentEntry& entry, const std::string& file,
                                           core::FileProvider& files) {
  for (const auto embed : {embedMeshFile, embedPointFile, embedFieldFile}) {
    if (auto problem = embed(entry, file, files)) {
      return problem;
    }
  }
  return std::nullopt;
}

}  // namespace espalier::environment
