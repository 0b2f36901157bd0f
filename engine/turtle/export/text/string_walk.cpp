#include "engine/turtle/export/text/string_walk.h"

#include "engine/core/check.h"
#include "engine/derivation/state/string_text.h"

namespace espalier::turtle {

namespace {

/// Hands on the modules of one plant after the other, up to the ones that a state is known for.
class Walk {
 public:
  Walk(const ExportInput& input, const ExportProgress& progress, const std::function<void(const VisitedModule&)>& visit)
      : input_(input), progress_(progress), visit_(visit) {
    for (const derivation::ModuleString* string : input.strings) {
      total_ += string->size();
    }
  }

  // all modules of the plants before, then those of `plant` before `end`
  void advance(std::uint32_t plant, std::uint64_t end, const TurtleRecord* state) {
    while (plant_ < plant) {
      pass(input_.strings[plant_]->size(), nullptr);
      ++plant_;
      module_ = 0;
      offset_ = 0;
    }
    if (plant_ < input_.strings.size()) {
      pass(end, state);
    }
  }

 private:
  void pass(std::uint64_t end, const TurtleRecord* state) {
    const derivation::ModuleString& string = *input_.strings[plant_];
    const language::Program& program = input_.programOf(plant_);
    for (; module_ < end; ++module_) {
      const core::ModuleTypeId type = string.types()[module_];
      const std::size_t arity = program.arity[type];
      visit_({plant_, module_, program.nameOf(type), string.parameters().subspan(offset_, arity), state});
      offset_ += arity;
      reportProgress(progress_, ++done_, total_);
    }
  }

  const ExportInput& input_;
  const ExportProgress& progress_;
  const std::function<void(const VisitedModule&)>& visit_;
  std::uint32_t plant_ = 0;
  std::uint64_t module_ = 0;  // the next
  std::uint64_t offset_ = 0;  // of its parameters
  std::uint64_t done_ = 0;    // modules of all plants
  std::uint64_t total_ = 0;
};

}  // namespace

std::optional<std::string> walkStrings(const ExportInput& input, const ExportProgress& progress,
                                       const std::function<void(const VisitedModule&)>& visit) {
  ESPALIER_CHECK(input.program != nullptr && input.visitModules);
  Walk walk(input, progress, visit);
  const auto problem = input.visitModules([&walk](const TurtleRecord& state, std::uint64_t first) {
    // the part that was cut off comes before
    walk.advance(state.plant, first, nullptr);
    walk.advance(state.plant, state.module + 1, &state);
  });
  if (!problem) {
    walk.advance(static_cast<std::uint32_t>(input.strings.size()), 0, nullptr);
  }
  return problem;
}

void appendModule(std::string& text, std::string_view symbol, std::span<const double> parameters,
                  core::Compatibility compatibility) {
  text.append(symbol);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    text.push_back(i == 0 ? '(' : ',');
    core::appendNumber(text, parameters[i], derivation::numberStyle(compatibility));
  }
  if (!parameters.empty()) {
    text.push_back(')');
  }
}

}  // namespace espalier::turtle
