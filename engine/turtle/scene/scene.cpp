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

SceneMark::SceneMark(const Scene& scene)
    : segments(scene.segments.size()),
      polygons(scene.polygons.size()),
      balls(scene.balls.size()),
      surfaces(scene.surfaces.size()),
      cylinders(scene.cylinders.size()),
      patches(scene.patches.size()),
      labels(scene.labels.size()) {}

bool SceneMark::isEmpty() const {
  return segments + polygons + balls + surfaces + cylinders + patches + labels == 0;
}

void SceneMark::restore(Scene& scene) const {
  scene.segments.resize(segments);
  scene.polygons.resize(polygons);
  scene.balls.resize(balls);
  scene.surfaces.resize(surfaces);
  scene.cylinders.resize(cylinders);
  scene.patches.resize(patches);
  scene.labels.resize(labels);
}

bool Scene::empty() const {
  return segments.empty() && polygons.empty() && balls.empty() && surfaces.empty() && cylinders.empty() &&
         patches.empty() && labels.empty();
}

}  // namespace espalier::turtle
