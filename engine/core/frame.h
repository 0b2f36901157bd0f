#pragma once

#include "engine/core/vec3.h"

namespace espalier::core {

/// The turtle's orientation: unit vectors heading H, left L and up U. The frame is left-handed, as in cpfg: L = H x U
/// and U = L x H. At the start H = +y, L = -x, U = -z; this U is the negative of that in Prusinkiewicz & Lindenmayer
/// (1990).
struct Frame {
  Vec3 heading{0.0, 1.0, 0.0};
  Vec3 left{-1.0, 0.0, 0.0};
  Vec3 up{0.0, 0.0, -1.0};

  constexpr bool operator==(const Frame&) const = default;
};

}  // namespace espalier::core
