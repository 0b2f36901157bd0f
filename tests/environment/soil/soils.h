#pragma once

#include "environment/soil/soil_layer.h"

namespace espalier::environment {

/// The soils of Vanderborght et al. (2005) and of the published root benchmarks, cm and day.
inline const SoilLayer kSand{0.045, 0.43, 0.15, 3.0, 1000.0, 1e-6};
inline const SoilLayer kLoam{0.08, 0.43, 0.04, 1.6, 50.0, 1e-6};
inline const SoilLayer kClay{0.1, 0.4, 0.01, 1.1, 10.0, 1e-6};

/// The loam of Carsel and Parrish (1988), cm and day.
inline const SoilLayer kMeanLoam{0.078, 0.43, 0.036, 1.56, 24.96, 1e-7};

}  // namespace espalier::environment
