#include "environment/obstacles/scene_file.h"

#include <algorithm>
#include <utility>

#include "engine/files/surfaces/background_scene.h"
#include "engine/files/utf8.h"

namespace espalier::environment {

tl::expected<SceneShapes, std::string> readScene(std::string_view text) {
  std::vector<files::BackgroundProblem> problems;
  files::BackgroundScene scene = files::readBackgroundScene(files::asUtf8(text), problems);
  const auto wrong = std::find_if(problems.begin(), problems.end(),
                                  [](const files::BackgroundProblem& problem) { return !problem.isUnknown; });
  if (wrong != problems.end()) {
    return tl::unexpected("line " + std::to_string(wrong->line) + ": " + wrong->message);
  }
  SceneShapes shapes;
  for (files::BackgroundShape& shape : scene.shapes) {
    if (shape.isSphere) {
      shapes.spheres.push_back({shape.centre, shape.radius});
    } else {
      shapes.meshes.push_back({std::move(shape.vertices), std::move(shape.triangles), false});
    }
  }
  return shapes;
}

}  // namespace espalier::environment
