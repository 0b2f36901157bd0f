#include "engine/derivation/parallel/text_writer.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string_view>

#include "engine/derivation/parallel/string_chunks.h"
#include "engine/derivation/state/module_spelling.h"

namespace espalier::derivation {
namespace {

// a piece and its text stay in the cache of a core
constexpr std::uint64_t kPieceModules = 32'768;

/// The order in which threads hand their pieces to the sink.
class Turns {
 public:
  explicit Turns(core::ByteSink& sink) : sink_(&sink) {}

  /// Waits until all pieces before this one are written, and writes it. False: the sink failed at an earlier piece.
  bool write(std::uint64_t piece, std::string_view text) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return next_ == piece || hasFailed_; });
    if (hasFailed_) {
      return false;
    }
    // until the sink returns the text counts as failed, so that an exception releases the other threads
    hasFailed_ = true;
    const Release release(changed_);
    sink_->write(text);
    hasFailed_ = false;
    ++next_;
    return true;
  }

 private:
  struct Release {
    explicit Release(std::condition_variable& changed) : changed_(&changed) {}
    ~Release() { changed_->notify_all(); }
    Release(const Release&) = delete;
    Release& operator=(const Release&) = delete;
    std::condition_variable* changed_;
  };

  core::ByteSink* sink_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t next_ = 0;  // the piece to be written
  bool hasFailed_ = false;
};

}  // namespace

void TextWriter::write(core::ByteSink& sink, const language::Program& program, const ModuleString& string,
                       core::NumberStyle style) {
  core::WorkerTeam alone(1);
  const bool isLong = string.size() > kPieceModules;
  if (isLong && team_ == nullptr) {
    team_ = std::make_unique<core::WorkerTeam>(threads_);
  }
  core::WorkerTeam& team = isLong ? *team_ : alone;
  const ModuleSpelling spelling(program);
  StringChunks pieces(program);
  pieces.cut(string, kPieceModules, team, nullptr);
  Turns turns(sink);
  std::atomic<std::uint64_t> nextPiece{0};
  team.onEveryWorker([&](unsigned) {
    NumberTexts numbers(style);
    core::Buffer<char> text;
    for (std::uint64_t piece = nextPiece++; piece < pieces.count(); piece = nextPiece++) {
      const ScanPlace begin = pieces.begin(piece);
      const ScanPlace end = pieces.begin(piece + 1);
      const auto types = string.types().subspan(begin.module, end.module - begin.module);
      const auto parameters = string.parameters().subspan(begin.offset, end.offset - begin.offset);
      text.resize(spelling.mostBytes(types.size(), parameters.size()));
      const char* const first = text.data();
      const char* const last = spelling.write(text.data(), types, parameters, numbers);
      if (!turns.write(piece, {first, static_cast<std::size_t>(last - first)})) {
        return;
      }
    }
  });
}

}  // namespace espalier::derivation
