#include "engine/turtle/export/text/module_table.h"

#include <vector>

#include "engine/core/check.h"
#include "engine/core/number_text.h"
#include "engine/derivation/parallel/text_writer.h"
#include "engine/derivation/state/string_text.h"
#include "engine/turtle/export/text/string_walk.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

namespace {

constexpr std::string_view kHeader =
    "plant,module,symbol,parameters,x,y,z,hx,hy,hz,lx,ly,lz,ux,uy,uz,width,colour,order,parent\n";
constexpr std::uint64_t kNone = ~std::uint64_t{0};
constexpr int kStateColumns = 14;

// a cell with any text
void appendField(std::string& line, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    line.append(text);
    return;
  }
  line.push_back('"');
  for (const char c : text) {
    line.append(c == '"' ? 2 : 1, c);
  }
  line.push_back('"');
}

void appendReal(std::string& line, double value) {
  core::appendNumber(line, value, core::NumberStyle::Shortest);
}

void appendVector(std::string& line, const core::Vec3& v) {
  for (const double component : {v.x, v.y, v.z}) {
    appendReal(line, component);
    line.push_back(',');
  }
}

void appendState(std::string& line, const TurtleRecord* state) {
  if (state == nullptr) {
    line.append(kStateColumns, ',');
    return;
  }
  appendVector(line, state->position);
  appendVector(line, state->frame.heading);
  appendVector(line, state->frame.left);
  appendVector(line, state->frame.up);
  appendReal(line, state->width);
  line.append("," + std::to_string(state->colour) + ",");
}

}  // namespace

std::optional<std::string> writeModuleTable(const ExportInput& input, const ExportTarget& target) {
  TextOutput out(target.sink);
  out << kHeader;
  std::vector<std::uint64_t> axes{kNone};  // the last module of each open axis
  std::uint32_t plant = 0;
  std::string line;
  auto problem = walkStrings(input, target.progress, [&](const VisitedModule& module) {
    if (module.plant != plant) {
      plant = module.plant;
      axes.assign(1, kNone);
    }
    const bool isOpening = module.symbol == "[" && module.parameters.empty();
    const bool isClosing = module.symbol == "]" && module.parameters.empty();
    const std::uint64_t parent = axes.back();
    if (isClosing && axes.size() > 1) {
      axes.pop_back();
    }
    line = std::to_string(plant) + "," + std::to_string(module.index) + ",";
    appendField(line, module.symbol);
    line.push_back(',');
    for (std::size_t i = 0; i < module.parameters.size(); ++i) {
      if (i > 0) {
        line.push_back(';');
      }
      appendReal(line, module.parameters[i]);
    }
    line.push_back(',');
    appendState(line, module.state);
    line.append(std::to_string(axes.size() - 1) + ",");
    line.append(parent == kNone ? std::string() : std::to_string(parent));
    out << line << '\n';
    if (isOpening) {
      axes.push_back(axes.back());
    } else if (!isClosing) {
      axes.back() = module.index;
    }
  });
  out.flush();
  return problem;
}

std::optional<std::string> writeStrings(const ExportInput& input, const ExportTarget& target) {
  ESPALIER_CHECK(input.program != nullptr);
  derivation::TextWriter writer(input.threads);
  for (std::size_t plant = 0; plant < input.strings.size(); ++plant) {
    const language::Program& program = input.programOf(plant);
    writer.write(target.sink, program, *input.strings[plant], derivation::numberStyle(program.compatibility));
    target.sink.write("\n");
  }
  return std::nullopt;
}

}  // namespace espalier::turtle
