#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/evolution/genome.h"
#include "clients/espalier/result.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"

namespace espalier::command {

/// Makes models of genomes: the model's text with other numbers in its macros, or with other productions.
class ModelVariants {
 public:
  /// `program` is the unchanged model. `variesProductions`: the productions vary; the model must then be a bracketed
  /// D0L-system with constant parameters. `longestSuccessor` is in modules. A problem: the model has no macro for a
  /// gene, or it is no such D0L-system.
  [[nodiscard]] static Result<ModelVariants> make(std::shared_ptr<const language::Program> program,
                                                  std::vector<Gene> genes, bool variesProductions,
                                                  std::size_t longestSuccessor);

  [[nodiscard]] const GenomeShape& shape() const { return shape_; }
  /// The model's own successors, by predecessor.
  [[nodiscard]] const std::vector<Successor>& successors() const { return successors_; }

  /// The text of a genome's model. It needs the view file and the included files of the model.
  [[nodiscard]] std::string text(const Genome& genome, const std::string& comment) const;
  /// The text of the view file of all models; empty: none.
  [[nodiscard]] std::string viewText() const;
  /// The Program of a genome, or the first error. `files` gives the view file and includes. Thread-safe when every
  /// thread has its own provider.
  [[nodiscard]] Result<std::shared_ptr<const language::Program>> program(const Genome& genome,
                                                                         core::FileProvider& files) const;

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
