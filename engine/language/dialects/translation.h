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

/// Text of a translation, with the place in the foreign text of each byte.
class MappedText {
 public:
  /// Bytes [begin, ...) of the text that come from the foreign text at `foreignOffset`: copies of consecutive bytes, or
  /// text made for the construct there.
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

/// Reports messages about a foreign text, with places in that text.
class DialectReport {
 public:
  /// Both must outlive the object.
  DialectReport(const files::SourceMap::File& file, core::DiagnosticList& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  void error(std::size_t offset, std::size_t length, std::string message, std::string hint = {});
  void warn(std::size_t offset, std::size_t length, std::string message, std::string hint = {});
  void note(std::size_t offset, std::size_t length, std::string message, std::string hint = {});

 private:
  void add(core::Severity severity, std::size_t offset, std::size_t length, std::string message, std::string hint);

  const files::SourceMap::File& file_;
  core::DiagnosticList& diagnostics_;
};

/// A translated model: the parts of the cpfg text, and the start and look of the turtle.
struct CpfgModel {
  std::uint64_t derivationLength = 1;
  std::vector<MappedText> items;        // before the axiom: `ignore:`, `Start:`, ...
  MappedText axiom;                     // modules; never empty
  std::vector<MappedText> productions;  // without newlines; empty: nothing is rewritten
  std::vector<MappedText> decomposition;
  std::vector<MappedText> drawing;  // productions of the homomorphism: the drawing of the symbols
  /// Productions of the homomorphism with turtle commands that cpfg does not have; `lost` or `needs` names them.
  std::vector<MappedText> ownDrawing;
  std::uint32_t decompositionDepth = 1;
  std::uint32_t drawingDepth = 1;

  double angleDegrees = 45.0;    // of turns without a parameter
  double headingDegrees = 90.0;  // of the first step: 0 is +x, counter-clockwise
  core::Vec3 position;           // where the turtle starts, length units
  int colour = 128;
  std::map<int, files::PaletteColour> palette;  // by turtle colour, 0: the background; empty: Espalier's own colours
  std::vector<std::string> viewCommands;

  /// Whether +, -, &, ^, / and \ without a parameter turn the turtle by `angleDegrees`. False when `drawing` defines
  /// them.
  bool turnsByAngle = true;
  bool isStochastic = false;       // productions have probabilities; cpfg uses them only with a seed
  std::vector<std::string> lost;   // parts that cpfg cannot express and a converted text lacks
  std::vector<std::string> needs;  // parts that the text needs and cpfg does not have: the text is not a cpfg model
};

/// The model's text. `isAlone`: as a file for other programs, that needs no view file: turns have their angle, and the
/// start of the turtle is written before the axiom.
[[nodiscard]] MappedText modelText(const CpfgModel& model, bool isAlone);
/// The view file of the text when it is not alone.
[[nodiscard]] std::string viewText(const CpfgModel& model);

/// Reports each bracket of foreign[begin, end) that has no partner there; `where` completes "in ...".
void checkBrackets(std::string_view foreign, std::size_t begin, std::size_t end, const std::string& where,
                   DialectReport& report);

/// Adds drawing productions `X --> *` for the given symbols without parameters that cpfg's turtle would obey.
void silence(const std::set<char>& symbols, std::string_view meaningful, CpfgModel& model);

/// A number as cpfg reads it.
[[nodiscard]] std::string cpfgNumber(double value);

}  // namespace espalier::language
