#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "engine/turtle/field.h"

namespace espalier::environment {

/// The text of a VTK image data file (.vti, XML) with the fields as cell data: doubles, base64, little-endian. All
/// fields must have the same cells; ParaView and VTK read it. O(cells).
/// `lengthUnit`: of places and sizes; the attribute LengthUnit of the image says it unless it is the metre.
[[nodiscard]] std::string writeVti(std::span<const turtle::Field> fields, std::string_view lengthUnit = "m");

/// Reads a .vti file with one piece, little-endian, whose cell data are ascii, inline base64 or appended (base64 or
/// raw), of any VTK number type, not compressed or by vtkZLibDataCompressor; units are kept in our own files. The error
/// is a sentence about the file without its subject. O(text + numbers).
[[nodiscard]] tl::expected<std::vector<turtle::Field>, std::string> readVti(std::string_view text);

/// The values as little-endian doubles, x fastest, and the JSON header that says so.
[[nodiscard]] std::string writeRaw(const turtle::Field& field);
[[nodiscard]] std::string writeRawHeader(const turtle::Field& field);
/// Reads both back; the error is a sentence without its subject.
[[nodiscard]] tl::expected<turtle::Field, std::string> readRaw(std::string_view header, std::string_view bytes);

/// The part of a field that a picture shows: along an axis (0: x, 1: y, 2: z) the mean of all cells, or the slice at a
/// coordinate.
struct FieldView {
  int axis = 2;
  std::optional<double> at;  // length
};

/// A plane of numbers, row by row from the top: the picture's right is x (z when seen along x), its top y (z when seen
/// along y, the smallest first).
struct FieldPlane {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<double> values;  // (height, width)
};

/// The slice or projection of a field; a sentence when the coordinate is outside. O(cells).
[[nodiscard]] tl::expected<FieldPlane, std::string> viewField(const turtle::Field& field, const FieldView& view);

/// The least and the greatest of the numbers that are finite; 0 and 0 when none is.
[[nodiscard]] std::pair<double, double> rangeOf(const FieldPlane& plane);

/// Colours of numbers between two bounds, dark blue over green to yellow (the map viridis of Smith & van der Walt
/// 2015): red, green, blue, opacity (height, width, 4). Equal bounds give the middle colour; a value that is not finite
/// is grey.
[[nodiscard]] std::vector<std::uint8_t> colourPlane(const FieldPlane& plane, double low, double high);

/// Least, mean and greatest value of a field and its integral over the box (value times length³).
struct FieldSummary {
  std::size_t count = 0;  // of cells with a number; the others have no part in what follows
  double minimum = 0.0;
  double mean = 0.0;
  double maximum = 0.0;
  double integral = 0.0;
};
[[nodiscard]] FieldSummary summaryOf(const turtle::Field& field);

}  // namespace espalier::environment
