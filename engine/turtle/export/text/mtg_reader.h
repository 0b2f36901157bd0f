#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/turtle/export/text/mtg.h"

namespace espalier::turtle::mtg {

inline constexpr std::size_t kNoVertex = std::numeric_limits<std::size_t>::max();
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// An entity and its relations.
struct Vertex {
  std::string entityClass;
  int scale = 0;
  char edge = '/';                  // to the parent: < or +; / for the first of its complex
  std::size_t parent = kNoVertex;   // at the same scale
  std::size_t complex = kNoVertex;  // the entity of the next coarser scale that it is a part of
  std::size_t origin = kNoVertex;   // the entity of a finer scale that it grows on, where the file says
  std::size_t firstPart = kNoVertex;
  std::uint64_t index = 0;  // behind the class; 0: none
  std::optional<std::string> text;
  std::vector<double> numbers;  // of the numeric features in the order of the columns, kUnknown where there is none
  std::vector<std::size_t> children;
};

/// Reads a file line by line into entities, then makes strings of them (mtg_strings.cpp). Used by readMtg().
class MtgReader {
 public:
  explicit MtgReader(std::string_view text) : text_(text) {}
  std::variant<MtgStrings, std::string> read();

 private:
  enum class Section : unsigned char { None, Classes, Description, Features, Graph };

  [[nodiscard]] std::string problem(const std::string& what) const { return std::to_string(line_) + ": " + what; }
  std::string readLine(std::string_view line);
  std::string readGraphLine(std::string_view line);
  std::string readCode(std::string_view code, std::size_t column);
  std::string readLabel(std::string_view& code, Vertex& vertex) const;
  std::string join(Vertex& vertex, std::size_t base) const;
  void joinPart(Vertex& vertex, std::size_t base) const;
  std::string addSeries(const Vertex& last, std::size_t& base);
  void add(Vertex vertex);
  std::string readFeatures(const std::vector<std::string_view>& columns, Vertex& vertex);
  [[nodiscard]] std::size_t ancestorAt(std::size_t vertex, int scale) const;
  [[nodiscard]] std::size_t endOf(std::size_t vertex, int scale) const;
  void chooseParameters();
  void appendModule(std::string& text, const Vertex& vertex) const;
  [[nodiscard]] MtgStrings strings() const;
  void appendTree(std::string& text, std::size_t root) const;

  std::string_view text_;
  std::size_t line_ = 0;
  Section section_ = Section::None;
  bool hasHeader_ = false;                 // of the section
  bool promisesEnd_ = false;               // its head says that the last line is kMtgEnd
  bool hasEnd_ = false;                    // it is, so far
  bool hasText_ = false;                   // a feature is the text of a module
  std::map<std::string, int> scales_;      // by class
  std::map<std::string, bool> isNumeric_;  // by feature
  std::vector<std::string> features_;      // by column from featureColumn_
  std::size_t featureColumn_ = kNoVertex;
  std::vector<Vertex> vertices_;
  mutable std::uint64_t looks_ = 0;                             // at entities, to find the ends of axes
  std::uint64_t seriesEntities_ = 0;                            // of all series so far
  std::map<std::string, std::vector<std::size_t>> parameters_;  // by class: which numbers of a vertex
  int coarsest_ = std::numeric_limits<int>::max();              // scale above 0 so far
  std::vector<std::size_t> lastOfColumn_;                       // vertex of the last code in each column
};

}  // namespace espalier::turtle::mtg
