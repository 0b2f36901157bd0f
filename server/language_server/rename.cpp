#include "server/language_server/rename.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "engine/core/work_meter.h"
#include "engine/language/preprocess/macro_table.h"
#include "server/language_server/handbook_rows.h"

namespace espalier::server {
namespace {

using language::NameKind;
using language::NameUse;

bool isIdentifier(std::string_view name) {
  return !name.empty() && language::isIdentifierStart(name.front()) &&
         std::all_of(name.begin(), name.end(), language::isIdentifierPart);
}

// why a module cannot be called so; empty: it can
std::string moduleNameProblem(const NameUse& name, const std::string& newName) {
  if (!name.isDeclared && handbookSymbol(name.name)) {
    return "'" + name.name + "' is a symbol of the turtle: another letter would draw nothing";
  }
  if (name.isDeclared) {
    return isIdentifier(newName) ? "" : "the name of a module has letters, digits and '_'";
  }
  if (newName.size() != 1 || !language::isIdentifierPart(newName.front())) {
    return "the name of this module is one letter or digit. 'Module:' declares longer names";
  }
  if (handbookSymbol(newName)) {
    return "'" + newName + "' is a symbol of the turtle: choose another letter";
  }
  return {};
}

std::string nameProblem(const NameUse& name, const std::string& newName) {
  if (name.kind == NameKind::Module) {
    return moduleNameProblem(name, newName);
  }
  if (name.kind == NameKind::Function) {
    return "'" + name.name + "' is a function of the language";
  }
  if (name.kind == NameKind::Unknown) {
    return "'" + name.name + "' is not defined: define it first";
  }
  return isIdentifier(newName) ? "" : "a name has letters, digits and '_', and begins with no digit";
}

/// A model with other texts in place of some of its files.
class EditedFiles final : public core::FileProvider {
 public:
  explicit EditedFiles(core::FileProvider& files) : files_(files) {}
  void put(const std::string& name, std::string text) { edited_.insert_or_assign(name, std::move(text)); }
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    const auto found = edited_.find(name);
    return found == edited_.end() ? files_.read(name) : std::optional<std::string>(found->second);
  }

 private:
  core::FileProvider& files_;
  std::map<std::string, std::string> edited_;
};

// how many names mean what each other name means, in the order of the text: equal for equal meanings
std::vector<std::size_t> meaningsOf(const std::vector<NameUse>& names) {
  std::vector<std::size_t> meanings;
  std::map<std::pair<NameKind, std::pair<std::string, std::uint32_t>>, std::size_t> seen;
  for (const NameUse& name : names) {
    core::pollWork();
    meanings.push_back(seen.emplace(std::pair(name.kind, std::pair(name.name, name.scope)), seen.size()).first->second);
    meanings.push_back(static_cast<std::size_t>(name.kind));
  }
  return meanings;
}

std::size_t errorCount(const ModelAnalysis& analysis) {
  return static_cast<std::size_t>(
      std::count_if(analysis.diagnostics.begin(), analysis.diagnostics.end(),
                    [](const core::Diagnostic& one) { return one.severity == core::Severity::Error; }));
}

}  // namespace

tl::expected<std::vector<TextEdit>, std::string> renameEdits(const ModelAnalysis& analysis, const NameUse& name,
                                                             const std::string& newName, core::FileProvider& files) {
  if (std::string problem = nameProblem(name, newName); !problem.empty()) {
    return tl::unexpected(std::move(problem));
  }
  if (newName == name.name) {
    return std::vector<TextEdit>{};
  }
  std::vector<TextEdit> edits;
  for (const NameUse& use : analysis.names) {
    if (!use.meansTheSameAs(name)) {
      continue;
    }
    if (use.isExpanded) {
      const files::SourceMap::File& file = analysis.map.files[use.file];
      return tl::unexpected("the macro '" + file.text.substr(use.offset, use.length) + "' brings the name '" +
                            name.name + "': rename it in the macro's definition by hand");
    }
    edits.push_back({use.file, use.offset, use.length});
  }
  // a place may be there twice: in a file that is included twice, or in a context that is read twice
  const auto key = [](const TextEdit& edit) { return std::pair(edit.file, edit.offset); };
  std::sort(edits.begin(), edits.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  edits.erase(std::unique(edits.begin(), edits.end(), [&](const auto& a, const auto& b) { return key(a) == key(b); }),
              edits.end());

  EditedFiles edited(files);
  for (std::size_t begin = 0; begin < edits.size();) {
    const files::SourceMap::File& file = analysis.map.files[edits[begin].file];
    std::string text;
    std::size_t copied = 0;  // bytes of the old text
    for (const std::uint32_t number = edits[begin].file; begin < edits.size() && edits[begin].file == number; ++begin) {
      core::pollWork();
      text.append(file.text, copied, edits[begin].offset - copied).append(newName);
      copied = edits[begin].offset + edits[begin].length;
    }
    edited.put(file.name, text.append(file.text, copied));
  }
  const auto after = analyseModel(analysis.file, edited);
  if (errorCount(*after) > errorCount(analysis) || meaningsOf(after->names) != meaningsOf(analysis.names)) {
    return tl::unexpected("'" + newName + "' has another meaning here: choose a name that the model does not use");
  }
  return edits;
}

}  // namespace espalier::server
