#include "tests/fuzz/targets.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "engine/language/format/disassembler.h"
#include "engine/language/preprocess/preprocessor.h"
#include "engine/language/view/view_file.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/snapshot.h"
#include "tests/fuzz/bundle.h"
#include "tests/fuzz/small_limits.h"

namespace espalier::fuzz {
namespace {

constexpr core::Compatibility kModes[] = {core::Compatibility::Espalier, core::Compatibility::Cpfg,
                                          core::Compatibility::CpfgBatch};

/// Every message must be one that can be shown.
void formatAll(const core::DiagnosticList& diagnostics) {
  for (const core::Diagnostic& diagnostic : diagnostics.entries()) {
    ESPALIER_CHECK(!core::formatDiagnostic(diagnostic).empty());
  }
}

/// `entry`: one of several models in the file; empty: the file itself.
language::CompileResult compileBundle(std::string_view text, core::Compatibility compatibility,
                                      const std::string& entry = {}) {
  core::MemoryFileProvider files = unbundle(text, kModel);
  language::CompileInput input;
  input.modelFile = kModel + (entry.empty() ? "" : ":" + entry);
  input.viewFile = files.read(kView) ? kView : "";
  input.compatibility = compatibility;
  input.limits = smallLimits();
  language::CompileResult result = language::compile(input, files);
  formatAll(result.diagnostics);
  ESPALIER_CHECK((result.program == nullptr) == result.diagnostics.hasErrors());
  return result;
}

}  // namespace

void fuzzPreprocessor(std::string_view text) {
  core::MemoryFileProvider files = unbundle(text, kModel);
  language::PreprocessInput input;
  input.file = kModel;
  input.limits = smallLimits();
  const language::PreprocessResult result = language::preprocess(input, files);
  formatAll(result.diagnostics);
  ESPALIER_CHECK(result.text.size() <= input.limits.maximumSourceBytes || result.diagnostics.hasErrors());
  // the map covers the text: some places of it
  const std::size_t step = result.text.size() / 16 + 1;
  for (std::size_t i = 0; i < result.text.size(); i += step) {
    const auto at = static_cast<std::uint32_t>(i);
    ESPALIER_CHECK(result.sourceMap.locate({at, at + 1}).line > 0);
  }
}

void fuzzCompile(std::string_view text) {
  for (const core::Compatibility compatibility : kModes) {
    const language::CompileResult result = compileBundle(text, compatibility);
    if (result.program != nullptr) {
      ESPALIER_CHECK(!language::disassemble(*result.program).empty());
    }
  }
  // files of other programs may hold several models
  constexpr std::size_t kMostEntries = 4;
  core::MemoryFileProvider files = unbundle(text, kModel);
  language::CompileInput input;
  input.modelFile = kModel;
  const std::vector<std::string> entries = language::entriesOf(input, files);
  for (std::size_t i = 0; i < std::min(entries.size(), kMostEntries); ++i) {
    (void)compileBundle(text, core::Compatibility::Espalier, entries[i]);
  }
}

void fuzzViewFile(std::string_view text) {
  for (const core::Compatibility compatibility : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
    core::MemoryFileProvider files = unbundle(text, kView);
    const language::ViewFileResult result = language::readViewFile(kView, files, compatibility, smallLimits());
    formatAll(result.diagnostics);
    ESPALIER_CHECK(!result.diagnostics.hasErrors());
    // the calls that a model can make
    for (const files::SplineFunction& function : result.settings.functions) {
      (void)function.value(0.3);
    }
    for (const files::ParametricCurve& curve : result.settings.curves) {
      (void)curve.point(0.7);
    }
    for (const files::BlobField& field : result.settings.blobFields) {
      (void)field.value({0.5, 0.5, 0.5});
    }
  }
}

void fuzzDerivation(std::string_view text) {
  constexpr int kSteps = 4;
  for (const core::Compatibility compatibility : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
    language::CompileResult compiled = compileBundle(text, compatibility);
    if (compiled.program == nullptr) {
      continue;
    }
    simulation::SimulationOptions options;
    options.limits = smallLimits();
    options.seed = 1;
    options.hasSeed = true;
    options.derivationLength = kSteps;
    simulation::Simulation simulation(compiled.program, std::vector<turtle::PlantPlacement>(1), nullptr, options);
    if (simulation.rewind()) {
      continue;
    }
    for (int step = 0; step < kSteps && !simulation.isFinished(); ++step) {
      const std::uint64_t before = simulation.stateHash();
      if (simulation.step()) {
        // a step that fails leaves everything as it was
        ESPALIER_CHECK(simulation.stateHash() == before);
        break;
      }
    }
    ESPALIER_CHECK(simulation.stringText().size() < 100'000'000);
    (void)simulation.scene();
    // a snapshot read back is the same state
    core::StringSink sink;
    simulation.save(sink);
    const std::uint64_t saved = simulation.stateHash();
    ESPALIER_CHECK(!simulation.restore(sink.text()));
    ESPALIER_CHECK(simulation.stateHash() == saved);
  }
}

}  // namespace espalier::fuzz
