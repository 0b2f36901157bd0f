#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/turtle/export/text/rsml.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

/// The facts of a file beside its lines.
struct RsmlFacts {
  std::string_view unit;              // empty: unknown
  std::optional<std::uint64_t> step;  // of a file that holds one step
  std::span<const double> days;       // of emergence (segments); or empty
  const RsmlLabels* labels = nullptr;
};

/// Writes the elements of a file in the Root System Markup Language, each when it is called.
class RsmlText {
 public:
  explicit RsmlText(core::ByteSink& sink) : out_(sink) {}

  void beginScene(const RsmlFacts& facts);
  void endScene() {
    out_ << "</scene>\n</rsml>\n";
    out_.flush();
  }

  /// A label that is empty is left out.
  void beginPlant(std::string_view id, std::string_view label);
  void endPlant() { out_ << "</plant>\n"; }

  /// A root up to its first point; `parentNode`: the point of the root around it from which it grows.
  void beginRoot(std::string_view id, std::string_view label, std::optional<std::size_t> parentNode);
  /// `decimals`: digits behind the point; nothing: as many as read back as the same number.
  void point(const core::Vec3& place, std::optional<int> decimals);
  void endPoints();
  /// A function with a sample at each point up to the last one that has a value (values; not a number: none). Nothing
  /// is written where a value is missing in the middle, or where one sample of several points would be that of them
  /// all.
  void function(std::string_view name, std::span<const double> values);
  void endFunctions() { out_ << "</functions>\n"; }
  /// Behind its laterals.
  void endRoot() { out_ << "</root>\n"; }

 private:
  void escaped(std::string_view text);
  void named(std::string_view id, std::string_view label);
  void coordinate(const char* name, double value, std::optional<int> decimals);

  TextOutput out_;
  bool hasFunction_ = false;  // of the root that is written
};

/// Writes the roots of a file that was read as they were in it: in their order, with their hierarchy and names, with
/// the numbers that the file has. Points that come after the step are left out. False, and nothing is written: the
/// segments are not the lines of the labels after that step.
[[nodiscard]] bool writeLabelledRsml(std::span<const Segment> segments, std::uint64_t step, const RsmlFacts& facts,
                                     core::ByteSink& sink);

}  // namespace espalier::turtle
