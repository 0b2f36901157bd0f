#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

void Scene::clear() {
  segments.clear();
  polygons.clear();
  balls.clear();
  surfaces.clear();
  cylinders.clear();
  patches.clear();
  labels.clear();
}

bool Scene::empty() const {
  return segments.empty() && polygons.empty() && balls.empty() && surfaces.empty() && cylinders.empty() &&
         patches.empty() && labels.empty();
}

}  // namespace espalier::turtle
