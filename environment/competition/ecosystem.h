#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `ecosystem`: competition of plants for space by discs (spheres) of influence of their own radius, the
/// self-thinning of Deussen et al. (1998), section 4.
///
/// A query sends the radius of its disc (parameter 1, default 0). Discs overlap when the distance of their centres is
/// at most the sum of their radii. Parameter 1 becomes 0 when the disc is dominated, else 1. Without vigor, parameter 2
/// is a group (default 0): a disc is dominated by an overlapping one of its group with at least its radius. With
/// `vigor`, parameter 2 is a vigor (default 0): a disc is dominated by an overlapping one that is itself not dominated
/// and has more vigor, or the same vigor and a larger radius. Domination is settled from the strongest down, so it does
/// not depend on the order of queries; `order` "published" settles it in string order as the published program does,
/// where a disc that comes later still dominates. Stateless. O(n log n) for n discs.
extern const ProcessEntry kEcosystemProcess;

}  // namespace espalier::environment
