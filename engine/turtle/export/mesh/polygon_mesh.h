#pragma once

#include <span>

#include "engine/core/vec3.h"
#include "engine/turtle/export/mesh/mesh.h"

namespace espalier::turtle {

/// A filled polygon with one normal; texture coordinates run over its bounding box in its plane, from 0 to 1.
void appendPolygon(Mesh& mesh, std::span<const core::Vec3> vertices);

}  // namespace espalier::turtle
