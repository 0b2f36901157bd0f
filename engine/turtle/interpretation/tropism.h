#pragma once

#include <span>

#include "engine/core/elementary.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// Bends the turtle before F G f g by the tropisms and torques of the view file, with the elasticities of the state.
/// Tropisms: H turns toward E = sum of e (cos g T + sin g T x (H x T) / |H x T|) by |H x E| radians, at most 1 and not
/// below 1e-6; U is then carried without twist from the last drawn segment. Torques: U turns about H by |U x W| radians
/// away from W, the part of the sum of e T that is normal to H, and the result counts as the last frame. `elementary`:
/// the functions of the mode. O(movements).
void applyMovements(TurtleState& state, std::span<const files::Movement> movements, core::Elementary elementary = {});

/// The old single tropism, after the advance: H turns by asin(e T.U) in the H-U plane, then by asin(e T.L) in the H-L
/// plane.
void applyOldTropism(TurtleState& state, const files::OldTropism& tropism, core::Elementary elementary = {});

}  // namespace espalier::turtle
