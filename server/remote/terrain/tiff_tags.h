#pragma once

#include <string_view>

namespace espalier::server {

/// Whether the values of the tags of a GeoTIFF that say where its heights lie, in which units, and which of them are
/// none, lie inside of the file, in its first image. libtiff leaves out a tag whose values do not, and a file that was
/// cut would lose its unit in silence. True for what is no TIFF file: libtiff says so. O(tags).
[[nodiscard]] bool hasWholeGeoTags(std::string_view bytes);

}  // namespace espalier::server
