#include "engine/files/cpfg_command.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>

namespace espalier::files {
namespace {

/// A switch without effect: the words that it takes, and the text of the note about it. Empty: no note.
struct UnusedSwitch {
  std::string_view name;
  std::size_t argumentCount;
  std::string_view consequence;
};

constexpr std::string_view kWindow = "this program has no window; choose the size of a picture with its options";
constexpr std::string_view kOutput = "choose the output with the options of this program";

// longer names first where one begins with another
constexpr std::array kUnused = {
    UnusedSwitch{"-wpr", 2, kWindow},
    UnusedSwitch{"-wnb", 0, kWindow},
    UnusedSwitch{"-wnm", 0, kWindow},
    UnusedSwitch{"-wr", 2, kWindow},
    UnusedSwitch{"-wp", 2, kWindow},
    UnusedSwitch{"-wt", 1, kWindow},
    UnusedSwitch{"-w", 2, kWindow},
    UnusedSwitch{"-rmode", 1, ""},
    UnusedSwitch{"-strb", 1, kOutput},
    UnusedSwitch{"-str", 1, kOutput},
    UnusedSwitch{"-ps", 1, kOutput},
    UnusedSwitch{"-rgb", 1, kOutput},
    UnusedSwitch{"-ras", 1, kOutput},
    UnusedSwitch{"-tga", 1, kOutput},
    UnusedSwitch{"-ray", 1, kOutput},
    UnusedSwitch{"-gls", 1, kOutput},
    UnusedSwitch{"-vv", 1, kOutput},
    UnusedSwitch{"-obj", 1, kOutput},
    UnusedSwitch{"-pipestrb", 0, "strings are not read from standard input"},
    UnusedSwitch{"-mb", 0, "there is no menu bar"},
    UnusedSwitch{"-b", 1, "this program saves nothing by this switch"},
    UnusedSwitch{"-C", 1, "an environment is chosen with -e or by the options of this program"},
    UnusedSwitch{"-S", 1, "this program has its own server"},
    UnusedSwitch{"-P", 1, "the model is read by the built-in preprocessor"},
    UnusedSwitch{"-V", 0, ""},
    UnusedSwitch{"-v", 0, ""},
    UnusedSwitch{"-d", 0, ""},
};

/// The block of `-m`, `-m2`: 1 without a number; nothing when the rest is not a number.
std::optional<int> blockOf(std::string_view digits) {
  if (digits.empty()) {
    return 1;
  }
  TextCursor cursor(digits);
  const std::optional<int> block = cursor.integer();
  return cursor.atEnd() ? block : std::nullopt;
}

class CommandReader {
 public:
  CommandReader(const DataFile& file, const std::vector<CommandWord>& words) : file_(file), words_(words) {}

  FolderCommand read() {
    for (next_ = 1; next_ < words_.size();) {
      const CommandWord& word = words_[next_++];
      if (word.text.size() > 1 && word.text.front() == '-') {
        readSwitch(word);
      } else {
        readFile(word);
      }
    }
    return std::move(command_);
  }

 private:
  void readSwitch(const CommandWord& word) {
    const std::string_view text = word.text;
    for (const UnusedSwitch& unused : kUnused) {
      if (unused.name == text) {
        next_ = std::min(next_ + unused.argumentCount, words_.size());
        if (!unused.consequence.empty()) {
          note(word, "the switch " + word.text + " is not used: " + std::string(unused.consequence));
        }
        return;
      }
    }
    switch (text[1]) {
      case 'm':
      case 'M':
        return readColours(word);
      case 'e':
        if (const CommandWord* file = argument(word, "an environment file")) {
          command_.environment = file->text;
        }
        return;
      case 'a':
        command_.startsInAnimation = true;
        return;
      case 'c':
        return readColourBase(word);
      case 's':
        return;  // the initial size of the string; our strings grow as needed
      case 'h':
        command_.writesAfterHomomorphism = true;
        return;
      case 'g':
        command_.isBatch = true;
        note(word,
             "the switch -g runs in batch mode, which has other random numbers; choose --compat cpfg-batch for them");
        return;
      default:
        readUnknown(word);
    }
  }

  /// A number behind an unknown switch belongs to it: it is no file.
  void readUnknown(const CommandWord& word) {
    warn(word, "unknown switch '" + word.text + "' is ignored");
    if (next_ < words_.size()) {
      TextCursor cursor(words_[next_].text);
      next_ += cursor.number() && cursor.atEnd() ? 1 : 0;
    }
  }

  void readColours(const CommandWord& word) {
    const std::optional<int> block = blockOf(std::string_view(word.text).substr(2));
    if (!block) {
      return readUnknown(word);
    }
    const CommandWord* file = argument(word, "a colour file");
    if (*block < 0 || *block > Palette::kLargestBlock) {
      return warn(word, "the colour block of " + word.text.substr(0, 2) + " is 0 to 11, found '" + word.text +
                            "'; its file is ignored");
    }
    if (file != nullptr) {
      command_.colours.push_back({file->text, *block, word.text[1] == 'M'});
    }
  }

  void readColourBase(const CommandWord& word) {
    const CommandWord* base = argument(word, "a number");
    if (base == nullptr) {
      return;
    }
    TextCursor cursor(base->text);
    const std::optional<int> value = cursor.integer();
    if (!value || *value < 0 || *value > Palette::kLargestBlock) {
      return warn(*base, "the colour base of -c is 0 to 11, found '" + base->text + "'");
    }
    command_.colourBase = *value;
  }

  /// The next word; null, with a warning, when there is none.
  const CommandWord* argument(const CommandWord& word, const std::string& expected) {
    if (next_ >= words_.size()) {
      warn(word, "expected " + expected + " after '" + word.text + "', found the end of the command");
      return nullptr;
    }
    return &words_[next_++];
  }

  /// The position of a file name decides its meaning, not its suffix.
  void readFile(const CommandWord& word) {
    if (command_.model.empty()) {
      command_.model = word.text;
    } else if (command_.view.empty()) {
      command_.view = word.text;
    } else if (command_.animation.empty()) {
      command_.animation = word.text;
    } else {
      warn(word, "'" + word.text + "' is ignored: a command names only a model, a view file and an animation file");
    }
  }

  void warn(const CommandWord& at, std::string message) const { file_.warn(at.range, std::move(message)); }
  void note(const CommandWord& at, std::string message) const { file_.note(at.range, std::move(message)); }

  const DataFile& file_;
  const std::vector<CommandWord>& words_;
  std::size_t next_ = 1;
  FolderCommand command_;
};

}  // namespace

std::vector<CommandWord> commandWords(TextCursor line) {
  constexpr std::string_view kEnds = "|;&<>";
  std::vector<CommandWord> words;
  for (line.skipBlanks(); !line.atEnd() && kEnds.find(line.peek()) == std::string_view::npos; line.skipBlanks()) {
    const std::size_t begin = line.position();
    CommandWord word;
    char quote = 0;
    while (!line.atEnd()) {
      const char c = line.peek();
      if (quote == 0 && (c == ' ' || c == '\t' || c == '\r' || kEnds.find(c) != std::string_view::npos)) {
        break;
      }
      line.setPosition(line.position() + 1);
      if (quote != 0 ? c == quote : (c == '"' || c == '\'')) {
        quote = quote != 0 ? '\0' : c;
      } else {
        word.text += c;
      }
    }
    word.range = line.rangeFrom(begin);
    words.push_back(std::move(word));
  }
  return words;
}

bool runsProgram(std::string_view word, std::string_view program) {
  const std::size_t slash = word.find_last_of("/\\");
  if (slash != std::string_view::npos) {
    word.remove_prefix(slash + 1);
  }
  if (word.ends_with(".exe")) {
    word.remove_suffix(4);
  }
  return word == program;
}

FolderCommand readCpfgCommand(const DataFile& file, const std::vector<CommandWord>& words) {
  return CommandReader(file, words).read();
}

}  // namespace espalier::files
