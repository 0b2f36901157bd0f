#include "server/remote/trace_file.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "server/remote/control_group.h"
#include "server/remote/zstd_context.h"

namespace espalier::server {
namespace {

constexpr std::string_view kCompressedSuffix = ".zst";
constexpr std::array<unsigned char, 4> kCompressedMagic{0x28, 0xB5, 0x2F, 0xFD};
constexpr std::size_t kPieceBytes = 1U << 20U;

}  // namespace

struct TraceFile::Compressor {
  ZstdCompressor context = makeZstdCompressor();
  std::string piece = std::string(ZSTD_CStreamOutSize(), '\0');
};

tl::expected<std::unique_ptr<TraceFile>, std::string> TraceFile::create(const std::string& name, DiskRoom* room) {
  std::FILE* file = std::fopen(name.c_str(), "wb");
  if (file == nullptr) {
    return tl::unexpected("cannot write the trace '" + name + "': " + std::strerror(errno) +
                          "; give a file in a folder that exists.");
  }
  return std::unique_ptr<TraceFile>(new TraceFile(name, file, name.ends_with(kCompressedSuffix), room));
}

TraceFile::TraceFile(std::string name, std::FILE* file, bool isCompressed, DiskRoom* room)
    : name_(std::move(name)),
      file_(file),
      room_(room),
      compressor_(isCompressed ? std::make_unique<Compressor>() : nullptr) {}

TraceFile::~TraceFile() {
  (void)close();
}

void TraceFile::put(std::string_view bytes) {
  if (file_ == nullptr || !problem_.empty()) {
    return;
  }
  if (room_ != nullptr) {
    outOfRoom_ = room_->take(bytes.size());
    if (outOfRoom_ != nullptr) {
      problem_ = "there is no room for more";
      return;
    }
    takenBytes_ += bytes.size();
  }
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) {
    problem_ = std::strerror(errno);
  }
}

std::uint64_t TraceFile::memoryBytes() const {
  return compressor_ == nullptr ? 0 : ZSTD_sizeof_CCtx(compressor_->context.get()) + compressor_->piece.capacity();
}

void TraceFile::compress(std::string_view bytes, int directive) {
  ZSTD_inBuffer input{bytes.data(), bytes.size(), 0};
  const auto mode = static_cast<ZSTD_EndDirective>(directive);
  std::size_t left = 0;
  do {
    ZSTD_outBuffer output{compressor_->piece.data(), compressor_->piece.size(), 0};
    left = ZSTD_compressStream2(compressor_->context.get(), &output, &input, mode);
    if (ZSTD_isError(left) != 0) {
      problem_ = ZSTD_getErrorName(left);
      return;
    }
    put(std::string_view(compressor_->piece).substr(0, output.pos));
  } while (mode == ZSTD_e_continue ? input.pos < input.size : left != 0);
}

void TraceFile::write(std::string_view bytes) {
  if (compressor_ != nullptr) {
    compress(bytes, ZSTD_e_continue);
  } else {
    put(bytes);
  }
}

void TraceFile::flush() {
  if (file_ == nullptr) {
    return;
  }
  if (compressor_ != nullptr) {
    compress({}, ZSTD_e_flush);
  }
  if (std::fflush(file_) != 0 && problem_.empty()) {
    problem_ = std::strerror(errno);
  }
}

std::optional<std::string> TraceFile::close() {
  if (file_ != nullptr) {
    if (compressor_ != nullptr) {
      compress({}, ZSTD_e_end);
    }
    if (std::fclose(file_) != 0 && problem_.empty()) {
      problem_ = std::strerror(errno);
    }
    file_ = nullptr;
    // a full disk has less than was taken
    std::error_code error;
    const std::uint64_t bytes = room_ == nullptr ? 0 : std::filesystem::file_size(name_, error);
    if (room_ != nullptr && !error) {
      room_->add(static_cast<std::int64_t>(bytes) - static_cast<std::int64_t>(takenBytes_));
    }
  }
  return problem_.empty() ? std::nullopt : std::optional(problem());
}

std::string TraceFile::problem() const {
  return problem_.empty() ? std::string() : "the trace '" + name_ + "' is not complete: " + problem_ + ".";
}

struct TraceFileSource::Decompressor {
  ZstdDecompressor context = makeZstdDecompressor();
  std::string packed;        // a piece of the file
  std::size_t used = 0;      // bytes of it that were decompressed
  bool hasHeldBack = false;  // the last output was full: there may be more without further input
};

tl::expected<std::unique_ptr<TraceFileSource>, std::string> TraceFileSource::open(const std::string& name) {
  std::FILE* const file = std::fopen(name.c_str(), "rb");
  if (file == nullptr) {
    return tl::unexpected("cannot read the trace '" + name + "': " + std::strerror(errno) +
                          ". Check the name and the working folder.");
  }
  std::unique_ptr<TraceFileSource> source(new TraceFileSource(name, file));
  if (auto problem = source->fillFromFile(source->piece_)) {
    return tl::unexpected(std::move(*problem));
  }
  if (source->piece_.size() >= kCompressedMagic.size() &&
      std::memcmp(source->piece_.data(), kCompressedMagic.data(), kCompressedMagic.size()) == 0) {
    source->decompressor_ = std::make_unique<Decompressor>();
    source->decompressor_->packed.swap(source->piece_);
  }
  return source;
}

TraceFileSource::TraceFileSource(std::string name, std::FILE* file) : name_(std::move(name)), file_(file) {}

TraceFileSource::~TraceFileSource() {
  (void)std::fclose(file_);
}

std::optional<std::string> TraceFileSource::fillFromFile(std::string& piece) {
  piece.resize(kPieceBytes);
  piece.resize(std::fread(piece.data(), 1, piece.size(), file_));
  if (std::ferror(file_) != 0) {
    return "cannot read the trace '" + name_ + "': " + std::strerror(errno) + ".";
  }
  return std::nullopt;
}

std::optional<std::string> TraceFileSource::fill() {
  given_ = 0;
  piece_.clear();
  if (decompressor_ == nullptr) {
    return fillFromFile(piece_);
  }
  Decompressor& state = *decompressor_;
  while (piece_.empty()) {
    if (state.used == state.packed.size() && !state.hasHeldBack) {
      state.used = 0;
      if (auto problem = fillFromFile(state.packed)) {
        return problem;
      }
      if (state.packed.empty()) {
        return std::nullopt;
      }
    }
    piece_.resize(kPieceBytes);
    ZSTD_inBuffer input{state.packed.data(), state.packed.size(), state.used};
    ZSTD_outBuffer output{piece_.data(), piece_.size(), 0};
    const std::size_t result = ZSTD_decompressStream(state.context.get(), &output, &input);
    if (ZSTD_isError(result) != 0) {
      return "the trace '" + name_ + "' is damaged: " + ZSTD_getErrorName(result) + ".";
    }
    state.used = input.pos;
    state.hasHeldBack = output.pos == output.size;
    piece_.resize(output.pos);
  }
  return std::nullopt;
}

std::optional<std::string> TraceFileSource::read(std::size_t count, std::string& bytes) {
  while (count > 0) {
    if (given_ == piece_.size()) {
      if (auto problem = fill()) {
        return problem;
      }
      if (piece_.empty()) {
        return std::nullopt;
      }
    }
    const std::size_t part = std::min(count, piece_.size() - given_);
    bytes.append(piece_, given_, part);
    given_ += part;
    count -= part;
  }
  return std::nullopt;
}

std::uint64_t maximumTraceEventBytes() {
  constexpr std::uint64_t kMostBytes = 256'000'000;
  return std::min(kMostBytes, usableMemoryBytes() / 4);
}

}  // namespace espalier::server
