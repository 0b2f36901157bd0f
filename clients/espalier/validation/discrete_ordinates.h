#pragma once

#include <optional>

#include "clients/espalier/validation/closed_forms.h"

namespace espalier::validation {

/// The light fluxes of a layer of small leaves without a preferred direction, over a ground: the equation of transfer
/// by discrete ordinates (Ross 1981; leaves of both sides alike scatter by the kernel (ρ I₋ + τ I₊)/π with
/// I₋ = (sin β − β cos β)/3π, I₊ = I₋ + cos β/3 and β the angle of turn). A beam from a zenith angle in degrees, or a
/// uniform sky. Accurate to about 2·10⁻⁴.
[[nodiscard]] LayerFluxes sphericalLayer(double leafAreaIndex, double rho, double tau, double ground,
                                         std::optional<double> zenithDegrees);

}  // namespace espalier::validation
