#pragma once

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "clients/espalier/evolution/genome.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"

namespace espalier::command {

/// Makes models of genomes: the model's text with other numbers in its macros, or with other productions.
class ModelVariants {
 public:
  /// `program` is the model as it is. `variesProductions`: the productions vary, which must be those of a bracketed
  /// D0L-system whose parameters are constants. `longestSuccessor`: of modules. Or an error sentence: a gene that the
  /// model has no macro for, a production of another kind.
  [[nodiscard]] static std::variant<ModelVariants, std::string> make(std::shared_ptr<const language::Program> program,
                                                                     std::vector<Gene> genes, bool variesProductions,
                                                                     std::size_t longestSuccessor);

  [[nodiscard]] const GenomeShape& shape() const { return shape_; }
  /// The model's own successors, by predecessor.
  [[nodiscard]] const std::vector<Successor>& successors() const { return successors_; }

  /// The text of a genome's model, complete in itself but for its view file and what it includes.
  [[nodiscard]] std::string text(const Genome& genome, const std::string& comment) const;
  /// The text of the view file that all of them have; empty: none.
  [[nodiscard]] std::string viewText() const;
  /// The Program of a genome, or the first error. `files` gives the view file and includes. Thread-safe for providers
  /// of their own.
  [[nodiscard]] std::variant<std::shared_ptr<const language::Program>, std::string> program(
      const Genome& genome, core::FileProvider& files) const;

 private:
  ModelVariants() = default;
  [[nodiscard]] std::string productionText(const Genome& genome) const;

  std::shared_ptr<const language::Program> base_;
  GenomeShape shape_;
  std::vector<Successor> successors_;
  std::string source_;  // the model file's text
  std::string head_;    // of it, up to the axiom, and
  std::string tail_;    // from the homomorphism or the end on; both empty unless productions vary
};

}  // namespace espalier::command
