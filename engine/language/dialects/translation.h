#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/vec3.h"
#include "engine/files/colour_files.h"
#include "engine/files/source_map.h"

namespace espalier::language {

/// Text of a translation that knows for each byte which place of the foreign text it stands for.
class MappedText {
 public:
  /// Bytes [begin, ...) of the text that stand for the foreign text at `foreignOffset`: as copies of consecutive bytes,
  /// or all of them for the construct there.
  struct Run {
    std::uint32_t begin = 0;
    std::uint32_t foreignOffset = 0;
    bool isCopied = false;
  };

  MappedText() = default;
  /// Text made for the construct at an offset of the foreign text.
  MappedText(std::string_view made, std::size_t foreignOffset) { make(made, foreignOffset); }

  MappedText& copy(std::string_view foreign, std::size_t foreignOffset);
  MappedText& make(std::string_view made, std::size_t foreignOffset);
  MappedText& add(const MappedText& other);

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  [[nodiscard]] bool empty() const { return text_.empty(); }

 private:
  void append(std::string_view text, std::size_t foreignOffset, bool isCopied);

  std::string text_;
  std::vector<Run> runs_;  // sorted, without gaps
};

/// Messages about a foreign text, in its own lines.
class DialectReport {
 public:
  /// Both must outlive the object.
  DialectReport(const SourceMap::File& file, core::DiagnosticList& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  void error(std::size_t offset, std::size_t length, std::string message, std::string hint = {});
  void warn(std::size_t offset, std::size_t length, std::string message, std::string hint = {});
  void note(std::size_t offset, std::size_t length, std::string message, std::string hint = {});

 private:
  void add(core::Severity severity, std::size_t offset, std::size_t length, std::string message, std::string hint);

  const SourceMap::File& file_;
  core::DiagnosticList& diagnostics_;
};

/// A model in the terms of cpfg, as a dialect's reader makes it: what goes into the model's text, and how its turtle
/// starts and looks.
struct CpfgModel {
  std::uint64_t derivationLength = 1;
  std::vector<MappedText> items;        // before the axiom: `ignore:`, `Start:`, ...
  MappedText axiom;                     // modules; never empty
  std::vector<MappedText> productions;  // without newlines; empty: nothing is rewritten
  std::vector<MappedText> drawing;      // productions of the homomorphism: what the symbols draw

  double angleDegrees = 45.0;    // of turns without a parameter
  double headingDegrees = 90.0;  // of the first step: 0 is +x, counter-clockwise
  core::Vec3 position;           // where the turtle starts, length units
  int colour = 128;
  std::map<int, PaletteColour> palette;  // by turtle colour, 0: the background; empty: Espalier's own colours
  std::vector<std::string> viewCommands;

  /// Whether +, -, &, ^, / and \ without a parameter are drawn as the turtle does, by `angleDegrees`. False when
  /// `drawing` says what they do.
  bool turnsByAngle = true;
  bool isStochastic = false;       // productions have probabilities, which count in cpfg only beside a seed
  std::vector<std::string> lost;   // what cpfg cannot say and the text alone leaves out, for who converts
  std::vector<std::string> needs;  // what the text needs and cpfg does not have: it is no cpfg model
};

/// The model's text. `isAlone`: as a file for other programs, that needs no view file: turns have their angle, and the
/// start of the turtle is written before the axiom.
[[nodiscard]] MappedText modelText(const CpfgModel& model, bool isAlone);
/// The view file that belongs to the text which does not stand alone.
[[nodiscard]] std::string viewText(const CpfgModel& model);

/// Reports each bracket of foreign[begin, end) that has no partner there; `where` completes "in ...".
void checkBrackets(std::string_view foreign, std::size_t begin, std::size_t end, const std::string& where,
                   DialectReport& report);

/// Adds drawing productions `X --> *` for those of the symbols without parameters that cpfg's turtle would act on.
void silence(const std::set<char>& symbols, std::string_view meaningful, CpfgModel& model);

/// A number as cpfg reads it.
[[nodiscard]] std::string cpfgNumber(double value);

}  // namespace espalier::language
