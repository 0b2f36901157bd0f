#include "engine/language/format/formatter.h"

#include <array>
#include <memory>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "engine/files/utf8.h"
#include "engine/language/compiler.h"
#include "engine/language/format/item_layout.h"
#include "engine/language/format/program_comparison.h"

namespace espalier::language {
namespace {

/// The caller's files, with another text for the model file.
class ReplacedFile final : public core::FileProvider {
 public:
  ReplacedFile(core::FileProvider& files, const std::string& name, const std::string& text)
      : files_(files), name_(name), text_(text) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    return name == name_ ? std::optional<std::string>(text_) : files_.read(name);
  }

 private:
  core::FileProvider& files_;
  const std::string& name_;
  const std::string& text_;
};

/// The offsets of the newlines of file 0, the model, that stand in the preprocessed text.
std::unordered_set<std::uint32_t> activeLineEnds(const Program& program) {
  std::unordered_set<std::uint32_t> ends;
  const std::vector<files::SourceMap::Segment>& segments = program.sourceMap.segments;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const std::size_t end = i + 1 < segments.size() ? segments[i + 1].outputBegin : program.text.size();
    if (segments[i].file != 0 || segments[i].expansion != files::SourceMap::kNoExpansion) {
      continue;
    }
    for (std::size_t k = segments[i].outputBegin; k < end; ++k) {
      if (program.text[k] == '\n') {
        ends.insert(segments[i].fileOffset + static_cast<std::uint32_t>(k - segments[i].outputBegin));
      }
    }
  }
  return ends;
}

class Formatter {
 public:
  Formatter(const CompileInput& input, core::FileProvider& files) : input_(input), files_(files) {}

  FormatResult run() {
    FormatResult result;
    CompileResult compiled = compile(input_, files_);
    result.diagnostics = std::move(compiled.diagnostics);
    // as the preprocessor reads it: the offsets of the program count in this text
    result.text = files::readableText(files_.read(input_.modelFile).value_or(std::string()));
    if (!compiled.program) {
      return result;
    }
    result.isCompiled = true;
    compileOriginals(compiled.program);
    const CodeOfFile code = readCode(result.text, activeLineEnds(*compiled.program));
    code_ = &code;
    newline_ = result.text.find("\r\n") != std::string::npos ? "\r\n" : "\n";
    items_ = ItemLayout(code, compiled.program->symbols).run(result.untouchedItems);
    // nearly every model keeps its meaning in the new layout as a whole
    isAccepted_.assign(items_.size(), true);
    if (!isSame(assemble())) {
      isAccepted_.assign(items_.size(), false);
      areBlanksTidied_ = isSame(assemble());
      accept(0, items_.size());
    }
    for (std::size_t i = 0; i < items_.size(); ++i) {
      result.untouchedItems += isAccepted_[i] ? 0U : 1U;
    }
    result.text = assemble();
    return result;
  }

 private:
  static constexpr std::array kModes{core::Compatibility::Espalier, core::Compatibility::Cpfg};

  /// `known`: the program in the mode of the input.
  void compileOriginals(const std::shared_ptr<const Program>& known) {
    for (const core::Compatibility mode : kModes) {
      CompileInput input = input_;
      input.compatibility = mode;
      originals_.push_back(mode == input_.compatibility ? known : compile(input, files_).program);
    }
  }

  /// Whether a text of the model means the same in both modes.
  [[nodiscard]] bool isSame(const std::string& text) {
    for (std::size_t i = 0; i < kModes.size(); ++i) {
      if (!originals_[i]) {
        continue;
      }
      ReplacedFile files(files_, input_.modelFile, text);
      CompileInput input = input_;
      input.compatibility = kModes[i];
      const std::shared_ptr<const Program> program = compile(input, files).program;
      if (!program || !isSameProgram(*program, *originals_[i])) {
        return false;
      }
    }
    return true;
  }

  /// Accepts a range of items that keeps the meaning; halves a range that does not.
  void accept(std::size_t begin, std::size_t end) {
    if (begin == end) {
      return;
    }
    const auto mark = [&](bool isAccepted) {
      for (std::size_t i = begin; i < end; ++i) {
        isAccepted_[i] = isAccepted;
      }
    };
    mark(true);
    if (isSame(assemble())) {
      return;
    }
    mark(false);
    if (end - begin > 1) {
      const std::size_t middle = begin + (end - begin) / 2;
      accept(begin, middle);
      accept(middle, end);
    }
  }

  /// The file with the accepted items in their new layout.
  [[nodiscard]] std::string assemble() const {
    std::string text;
    std::size_t emptyLines = 0;
    std::size_t item = 0;
    for (std::size_t i = 0; i < code_->lines.size(); ++i) {
      if (item < items_.size() && items_[item].firstLine == i) {
        const std::size_t current = item++;
        if (isAccepted_[current]) {
          appendLines(text, items_[current].text);
          emptyLines = 0;
          i = items_[current].lastLine;
          continue;
        }
      }
      const CodeOfFile::Line& line = code_->lines[i];
      const std::string_view raw = code_->file.substr(line.begin, line.end - line.begin);
      if (!areBlanksTidied_ || !line.isCode || line.hasSplice) {
        text += raw;
        emptyLines = 0;
        continue;
      }
      const std::size_t last = raw.find_last_not_of(" \t\r\n");
      if (last == std::string_view::npos && !line.startsInComment) {
        // at most one empty line, and none at the beginning
        if (++emptyLines == 1 && !text.empty()) {
          text += newline_;
        }
        continue;
      }
      emptyLines = 0;
      if (last != std::string_view::npos && raw[last] == '\\') {
        text += raw;
        continue;
      }
      text += raw.substr(0, last + 1);
      text += newline_;
    }
    while (areBlanksTidied_ && text.ends_with(newline_ + newline_)) {
      text.resize(text.size() - newline_.size());
    }
    return text;
  }

  void appendLines(std::string& text, const std::string& lines) const {
    for (const char c : lines) {
      if (c == '\n') {
        text += newline_;
      } else {
        text += c;
      }
    }
    text += newline_;
  }

  const CompileInput& input_;
  core::FileProvider& files_;
  std::vector<std::shared_ptr<const Program>> originals_;  // by mode; null: the model has errors in that mode
  const CodeOfFile* code_ = nullptr;
  std::string newline_;
  std::vector<LaidOutItem> items_;
  std::vector<bool> isAccepted_;
  bool areBlanksTidied_ = true;
};

}  // namespace

FormatResult format(const CompileInput& input, core::FileProvider& files) {
  return Formatter(input, files).run();
}

}  // namespace espalier::language
