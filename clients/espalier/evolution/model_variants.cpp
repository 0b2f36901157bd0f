#include "clients/espalier/evolution/model_variants.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>

#include "engine/core/diagnostic.h"
#include "engine/core/number_text.h"
#include "engine/language/compiler.h"

namespace espalier::command {
namespace {

using language::Program;

std::string numberText(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

// a module with constant parameters as text; nothing when a parameter is computed
std::optional<std::string> constantModule(const Program& program, const language::SuccessorModule& module,
                                          const std::vector<language::Expression>& expressions) {
  std::string text(program.nameOf(module.type));
  const std::uint16_t arity = program.arity[module.type];
  for (std::uint16_t i = 0; i < arity; ++i) {
    const language::Expression& expression = expressions[module.firstExpression + i];
    if (expression.kind != language::Expression::Kind::Constant) {
      return std::nullopt;
    }
    text += (i == 0 ? "(" : ",") + numberText(expression.constant);
  }
  return arity > 0 ? text + ")" : text;
}

std::optional<Successor> constantModules(const Program& program, const std::vector<language::SuccessorModule>& modules,
                                         const std::vector<language::Expression>& expressions) {
  Successor result;
  for (const language::SuccessorModule& module : modules) {
    const std::optional<std::string> text = constantModule(program, module, expressions);
    if (!text) {
      return std::nullopt;
    }
    result.push_back(*text);
  }
  return result;
}

// the name of the macro that a line defines; empty: none, or one with arguments
std::string_view definedName(std::string_view line) {
  const auto skipBlanks = [&line] { line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size())); };
  skipBlanks();
  if (line.empty() || line.front() != '#') {
    return {};
  }
  line.remove_prefix(1);
  skipBlanks();
  if (line.substr(0, 6) != "define") {
    return {};
  }
  line.remove_prefix(6);
  skipBlanks();
  const std::size_t end = std::min(line.find_first_of(" \t("), line.size());
  return end < line.size() && line[end] == '(' ? std::string_view() : line.substr(0, end);
}

std::vector<std::string_view> linesOf(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines.push_back(text.substr(0, end));
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return lines;
}

// whether a line begins with a keyword, whose first letter may be of either case
bool beginsWith(std::string_view line, std::string_view keyword) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  return line.size() >= keyword.size() && line.substr(1, keyword.size() - 1) == keyword.substr(1) &&
         (line[0] == keyword[0] || line[0] == static_cast<char>(keyword[0] - 'a' + 'A'));
}

// a model's text up to its axiom, and from what follows its productions on; nothing when it has no line of an axiom
std::optional<std::pair<std::string, std::string>> aroundProductions(std::string_view text) {
  std::pair<std::string, std::string> around;
  enum class Part : std::uint8_t { Head, Axiom, Productions, Tail } part = Part::Head;
  for (const std::string_view line : linesOf(text)) {
    if (part == Part::Head && beginsWith(line, "axiom:")) {
      part = Part::Axiom;
    } else if (part == Part::Axiom && !line.starts_with('\t')) {
      part = Part::Productions;
    }
    if (part == Part::Productions && (beginsWith(line, "homomorphism") || beginsWith(line, "endlsystem"))) {
      part = Part::Tail;
    }
    if (part != Part::Productions) {
      (part == Part::Tail ? around.second : around.first) += std::string(line) + "\n";
    }
  }
  return part == Part::Tail ? std::optional(around) : std::nullopt;
}

// why the productions of a model are not those of a bracketed D0L-system with constant parameters; empty: they are
std::string whyNotD0l(const Program& program) {
  const language::LSystem& system = program.systems.front();
  const auto where = [&](const language::Production& production) {
    const core::SourceLocation place = program.sourceMap.locate(production.range);
    return place.file + ":" + std::to_string(place.line) + ": '" + production.text + "' ";
  };
  constexpr const char* kAdvice =
      ". Productions vary in bracketed D0L-systems; use --gene to vary the numbers of this model";
  if (program.systems.size() > 1 || !system.decomposition.productions.empty()) {
    return std::string("the model has sub-L-systems or decomposition") + kAdvice;
  }
  std::vector<core::ModuleTypeId> seen;
  for (const language::Production& production : system.productions.productions) {
    if (production.predecessor.size() != 1 || program.arity[production.predecessor.front().type] > 0) {
      return where(production) + "has a predecessor with parameters, or of several modules" + kAdvice;
    }
    if (!production.leftContext.empty() || !production.rightContext.empty() || !production.newLeftContext.empty() ||
        !production.newRightContext.empty() || production.condition || production.probability ||
        !production.preBlock.empty() || !production.postBlock.empty()) {
      return where(production) + "has a context, a condition, a block or a probability" + kAdvice;
    }
    const core::ModuleTypeId type = production.predecessor.front().type;
    if (std::find(seen.begin(), seen.end(), type) != seen.end()) {
      return where(production) + "is the second production of its symbol" + kAdvice;
    }
    seen.push_back(type);
    const auto modules = constantModules(program, production.successor, production.expressions);
    if (!modules) {
      return where(production) + "computes a parameter" + kAdvice;
    }
    if (!isBalanced(*modules)) {
      return where(production) + "has a bracket without its partner" + kAdvice;
    }
  }
  return {};
}

}  // namespace

Result<ModelVariants> ModelVariants::make(std::shared_ptr<const Program> program, std::vector<Gene> genes,
                                          bool variesProductions, std::size_t longestSuccessor) {
  ModelVariants variants;
  variants.base_ = std::move(program);
  const Program& base = *variants.base_;
  for (const auto& source : base.sources) {
    if (source.name == base.modelFile) {
      variants.source_ = source.text;
    }
  }
  std::vector<std::string_view> macros;
  for (const std::string_view line : linesOf(variants.source_)) {
    if (const std::string_view name = definedName(line); !name.empty()) {
      macros.push_back(name);
    }
  }
  for (const Gene& gene : genes) {
    if (std::find(macros.begin(), macros.end(), gene.name) == macros.end()) {
      return problem("the model has no line '#define " + gene.name + " NUMBER'. " +
                     (macros.empty() ? "It has no #define: write one for the number that varies"
                                     : core::suggestName(gene.name, macros)));
    }
  }
  variants.shape_.genes = std::move(genes);
  variants.shape_.longestSuccessor = longestSuccessor;
  if (!variesProductions) {
    return variants;
  }

  if (std::string reason = whyNotD0l(base); !reason.empty()) {
    return problem(std::move(reason));
  }
  const language::LSystem& system = base.systems.front();
  const std::optional<Successor> axiom = constantModules(base, system.axiom, system.axiomExpressions);
  if (!axiom) {
    return problem("the axiom computes a parameter: productions vary only in models with constant parameters");
  }
  auto around = aroundProductions(variants.source_);
  if (!around) {
    return problem("the model has no line that begins with 'Axiom:': give a model that states its axiom in one line");
  }
  std::tie(variants.head_, variants.tail_) = std::move(*around);
  std::vector<std::string>& alphabet = variants.shape_.alphabet;
  const auto collect = [&alphabet](const Successor& modules) {
    for (const std::string& module : modules) {
      if (module != "[" && module != "]" && std::find(alphabet.begin(), alphabet.end(), module) == alphabet.end()) {
        alphabet.push_back(module);
      }
    }
  };
  collect(*axiom);
  for (const language::Production& production : system.productions.productions) {
    variants.shape_.predecessors.emplace_back(base.nameOf(production.predecessor.front().type));
    variants.successors_.push_back(*constantModules(base, production.successor, production.expressions));
    collect(variants.successors_.back());
  }
  return variants;
}

std::string ModelVariants::productionText(const Genome& genome) const {
  std::string text = head_;
  for (std::size_t i = 0; i < shape_.predecessors.size(); ++i) {
    std::string successor;
    for (const std::string& module : genome.successors[i]) {
      successor += module;
    }
    text += shape_.predecessors[i] + " --> " + (successor.empty() ? "*" : successor) + "\n";
  }
  return text + tail_;
}

std::string ModelVariants::text(const Genome& genome, const std::string& comment) const {
  std::string result = "/* " + comment + " */\n";
  if (!shape_.predecessors.empty()) {
    return result + productionText(genome);
  }
  for (const std::string_view line : linesOf(source_)) {
    const std::string_view name = definedName(line);
    std::string changed(line);
    for (std::size_t i = 0; i < shape_.genes.size(); ++i) {
      if (!name.empty() && name == shape_.genes[i].name) {
        changed = "#define " + shape_.genes[i].name + " " + numberText(genome.values[i]);
      }
    }
    result += changed + "\n";
  }
  return result;
}

std::string ModelVariants::viewText() const {
  for (const auto& source : base_->sources) {
    if (source.name == base_->viewFile && !base_->viewFile.empty()) {
      return source.text;
    }
  }
  return {};
}

Result<std::shared_ptr<const Program>> ModelVariants::program(const Genome& genome, core::FileProvider& files) const {
  // the files of the model, with the genome in the model file
  class WithModel final : public core::FileProvider {
   public:
    WithModel(core::FileProvider& others, const Program& base, std::optional<std::string> text)
        : others_(others), base_(base), text_(std::move(text)) {}
    [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
      if (text_ && name == base_.modelFile) {
        return text_;
      }
      // a view file that the dialect made exists only among the sources
      const auto found = std::find_if(base_.sources.begin(), base_.sources.end(),
                                      [&](const auto& source) { return source.name == name; });
      return found != base_.sources.end() ? found->text : others_.read(name);
    }

   private:
    core::FileProvider& others_;
    const Program& base_;
    std::optional<std::string> text_;
  };
  const bool variesProductions = !shape_.predecessors.empty();
  WithModel all(files, *base_, variesProductions ? std::optional(productionText(genome)) : std::nullopt);
  language::CompileInput input;
  input.modelFile = base_->modelFile;
  input.viewFile = base_->viewFile;
  input.compatibility = base_->compatibility;
  input.defines = base_->defines;
  for (std::size_t i = 0; i < shape_.genes.size(); ++i) {
    input.defines.emplace_back(shape_.genes[i].name, numberText(genome.values[i]));
  }
  const language::CompileResult compiled = language::compile(input, all);
  if (compiled.program) {
    return compiled.program;
  }
  for (const core::Diagnostic& diagnostic : compiled.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      return problem(core::formatDiagnostic(diagnostic));
    }
  }
  return problem("the model does not compile");
}

}  // namespace espalier::command
