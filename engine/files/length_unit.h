#pragma once

#include <optional>
#include <string>

namespace espalier::files {

inline constexpr unsigned kMetre = 9001;  // EPSG's number of this unit

/// The unit of length of a coordinate reference system of EPSG, as EPSG's number of the unit (9001 metre, 9002 foot,
/// 9003 US survey foot), from the database of PROJ. Nothing: PROJ is not installed, does not know the system, or it has
/// several parts with axes of their own.
[[nodiscard]] std::optional<unsigned> unitOfSystem(unsigned epsg);

/// The text about a unit that is not the metre: `has lengths in US survey feet (unit 9003 of EPSG), not in metres`.
[[nodiscard]] std::string notInMetres(unsigned unit);

}  // namespace espalier::files
