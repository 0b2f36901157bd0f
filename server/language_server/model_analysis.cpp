#include "server/language_server/model_analysis.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "engine/language/compiler.h"
#include "engine/language/parsed_model.h"
#include "engine/language/view/view_file.h"

namespace espalier::server {
namespace {

constexpr std::array<std::string_view, 5> kModelEndings{".l", ".ls", ".lpy", ".lsys", ".lsv"};

std::string viewBeside(const std::string& modelFile, core::FileProvider& files) {
  const std::size_t dot = modelFile.rfind('.');
  std::string view = modelFile.substr(0, dot) + ".v";
  return dot != std::string::npos && files.read(view) ? view : std::string{};
}

}  // namespace

std::optional<std::uint32_t> ModelAnalysis::fileIndex(const std::string& name) const {
  const auto& files = map.files;
  const auto found = std::find_if(files.begin(), files.end(), [&](const auto& known) { return known.name == name; });
  return found == files.end() ? std::nullopt
                              : std::optional<std::uint32_t>(static_cast<std::uint32_t>(found - files.begin()));
}

const language::NameUse* ModelAnalysis::nameAt(std::uint32_t fileNumber, std::uint32_t offset) const {
  const language::NameUse* best = nullptr;
  for (const language::NameUse& use : names) {
    // the caret may stand behind the last letter
    const bool isThere = use.file == fileNumber && use.offset <= offset && offset <= use.offset + use.length;
    if (!isThere || (use.isExpanded && use.kind != language::NameKind::Macro)) {
      continue;
    }
    const bool isInside = offset < use.offset + use.length;
    if (best == nullptr || isInside) {
      best = &use;
    }
    if (isInside && use.kind == language::NameKind::Macro) {
      return best;
    }
  }
  return best;
}

std::shared_ptr<const ModelAnalysis> analyseModel(const std::string& modelFile, core::FileProvider& files) {
  auto analysis = std::make_shared<ModelAnalysis>();
  analysis->file = modelFile;
  language::CompileInput input;
  input.modelFile = modelFile;
  input.viewFile = viewBeside(modelFile, files);
  const auto learn = [&](const language::ParsedModel& parsed) {
    analysis->isForeign = false;
    analysis->map = parsed.source.sourceMap;
    analysis->names = language::nameUses(parsed);
    analysis->macros = language::macroDefinitions(analysis->map);
    for (const files::SourceMap::File& file : analysis->map.files) {
      analysis->lines.emplace_back(file.text);
    }
  };
  analysis->diagnostics = language::compile(input, files, learn).diagnostics.entries();
  return analysis;
}

std::vector<core::Diagnostic> checkViewFile(const std::string& viewFile, core::FileProvider& files) {
  const language::CompileInput defaults;
  return language::readViewFile(viewFile, files, defaults.compatibility, defaults.limits).diagnostics.entries();
}

bool isModelFile(std::string_view path) {
  return std::any_of(kModelEndings.begin(), kModelEndings.end(),
                     [&](std::string_view ending) { return path.ends_with(ending); });
}

bool isViewFile(std::string_view path) {
  return path.ends_with(".v");
}

}  // namespace espalier::server
