#include "server/remote/trace_file.h"

#include <zstd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "server/remote/control_group.h"

namespace espalier::server {
namespace {

constexpr std::string_view kCompressedSuffix = ".zst";
constexpr std::array<unsigned char, 4> kCompressedMagic{0x28, 0xB5, 0x2F, 0xFD};
constexpr std::size_t kPieceBytes = 1U << 20U;

}  // namespace

struct TraceFile::Compressor {
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context{ZSTD_createCCtx(), &ZSTD_freeCCtx};
  std::string piece = std::string(ZSTD_CStreamOutSize(), '\0');
};

tl::expected<std::unique_ptr<TraceFile>, std::string> TraceFile::create(const std::string& name) {
  std::FILE* file = std::fopen(name.c_str(), "wb");
  if (file == nullptr) {
    return tl::unexpected("cannot write the trace '" + name + "': " + std::strerror(errno) +
                          "; give a file in a folder that exists.");
  }
  return std::unique_ptr<TraceFile>(new TraceFile(name, file, name.ends_with(kCompressedSuffix)));
}

TraceFile::TraceFile(std::string name, std::FILE* file, bool isCompressed)
    : name_(std::move(name)), file_(file), compressor_(isCompressed ? std::make_unique<Compressor>() : nullptr) {}

TraceFile::~TraceFile() {
  (void)close();
}

void TraceFile::put(std::string_view bytes) {
  if (file_ != nullptr && problem_.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) {
    problem_ = std::strerror(errno);
  }
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
  }
  return problem_.empty() ? std::nullopt : std::optional(problem());
}

std::string TraceFile::problem() const {
  return problem_.empty() ? std::string() : "the trace '" + name_ + "' is not complete: " + problem_ + ".";
}

std::optional<std::string> readTraceFile(const std::string& name, std::string& bytes, std::uint64_t bound) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "rb"), &std::fclose);
  if (file == nullptr) {
    return "cannot read the trace '" + name + "': " + std::strerror(errno) + ".";
  }
  bytes.clear();
  std::string piece(kPieceBytes, '\0');
  while (const std::size_t count = std::fread(piece.data(), 1, piece.size(), file.get())) {
    bytes.append(piece, 0, count);
  }
  if (std::ferror(file.get()) != 0) {
    return "cannot read the trace '" + name + "': " + std::strerror(errno) + ".";
  }
  if (bytes.size() < kCompressedMagic.size() ||
      std::memcmp(bytes.data(), kCompressedMagic.data(), kCompressedMagic.size()) != 0) {
    return std::nullopt;
  }

  // the last part of a killed program may be cut off: read as far as it goes
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  std::string decompressed;
  const std::uint64_t most = bound == 0 ? usableMemoryBytes() : bound;
  ZSTD_inBuffer input{bytes.data(), bytes.size(), 0};
  while (input.pos < input.size) {
    ZSTD_outBuffer output{piece.data(), piece.size(), 0};
    const std::size_t result = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(result) != 0) {
      return "the trace '" + name + "' is damaged: " + ZSTD_getErrorName(result) + ".";
    }
    if (decompressed.size() + output.pos > most) {
      return "the trace '" + name + "' has more than " + std::to_string(most) +
             " bytes when it is decompressed. Decompress it with zstd, and look at it in parts.";
    }
    decompressed.append(piece, 0, output.pos);
  }
  // the decompressor may hold back bytes that did not fit
  while (true) {
    ZSTD_outBuffer output{piece.data(), piece.size(), 0};
    const std::size_t result = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(result) != 0 || output.pos == 0) {
      break;
    }
    decompressed.append(piece, 0, output.pos);
  }
  bytes = std::move(decompressed);
  return std::nullopt;
}

}  // namespace espalier::server
