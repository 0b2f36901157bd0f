#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Whether a class of an MTG may contain the character: A to Z and a to z.
[[nodiscard]] constexpr bool isLetter(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

/// FORM-A has no mark at its end. A file of writeMtg() has this comment in its second line and ends with the other, so
/// that a copy that was cut is known.
inline constexpr std::string_view kMtgPromise = "# Espalier: the last line is '# end'";
inline constexpr std::string_view kMtgEnd = "# end";

/// Writes a multiscale tree graph (Godin & Caraglio 1998) in the text form FORM-A of AMAPmod and OpenAlea: plants at
/// scale 1, axes at scale 2 (class A, or a free letter), at scale 3 an entity for every module whose symbol begins with
/// a letter, joined by `<` along an axis; the axis of a branch is joined by `+`. Features of an entity: `Text`, the
/// string from the entity before it to this one without brackets, so that the whole string can be read back (`\x23`
/// stands for `#`, which begins comments, `\x5c` for the backslash); `Module`, its index; XX YY ZZ and HX HY HZ,
/// position and heading of the turtle after it; Diameter, Color, Order; Length, the distance from the end of the entity
/// before it, in world units (empty for the first entity of a plant whose string begins with it); Parent, the `Module`
/// of the entity from which it grows; Time, the step of the string; and its parameters P1, P2, … Entities of class Z
/// (or a free letter) stand where turtle commands or an empty branch belong to no module with a letter. An error
/// sentence when brackets do not match.
[[nodiscard]] std::optional<std::string> writeMtg(const ExportInput& input, const ExportTarget& target);

/// The strings of an MTG.
struct MtgStrings {
  std::vector<std::string> strings;  // one for each entity of the coarsest scale
  std::string modules;               // of entities without `Text`: the classes with the features that are their
                                     // parameters, as `Internode(length,width), Leaf`; else empty
  std::uint64_t missingNumbers = 0;  // parameters of these entities that the file does not have, and that are 0
};

/// Reads an MTG in FORM-A back into strings: entities of the finest scale become modules, in brackets what is joined
/// by `+`. An entity with a feature `Text` is that text. Another is its class with numbers as parameters: those of the
/// numeric features that any entity of its class has, 0 where it has none itself (an empty cell, `NA` or `NaN`), so
/// that all modules of a class have the same parameters. A value that is no number in a column of numbers is an error.
/// `E1<<E5` is a series of entities; of an entity that was observed several times (lines of `*`) the last numbers
/// count. A file that promises its end (kMtgPromise) must have it. An error is "LINE: what is wrong".
[[nodiscard]] std::variant<MtgStrings, std::string> readMtg(std::string_view text);

}  // namespace espalier::turtle
