#include "engine/files/utf8.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

namespace espalier::files {

std::size_t sequenceLength(std::string_view text) {
  if (text.empty()) {
    return 0;
  }
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xC2 && first < 0xE0 ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) {
    return 0;
  }
  for (std::size_t i = 1; i < length; ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U) {
      return 0;
    }
  }
  return length;
}

namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

void appendUtf8(std::string& text, std::uint32_t point) {
  const auto add = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (point < 0x80) {
    add(point);
  } else if (point < 0x800) {
    add(0xC0U | (point >> 6U));
    add(0x80U | (point & 0x3FU));
  } else if (point < 0x10000) {
    add(0xE0U | (point >> 12U));
    add(0x80U | ((point >> 6U) & 0x3FU));
    add(0x80U | (point & 0x3FU));
  } else {
    add(0xF0U | (point >> 18U));
    add(0x80U | ((point >> 12U) & 0x3FU));
    add(0x80U | ((point >> 6U) & 0x3FU));
    add(0x80U | (point & 0x3FU));
  }
}

std::string fromUtf16(std::string_view bytes, bool isBigEndian) {
  std::string text;
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]);
    const auto second = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<std::uint32_t>(isBigEndian ? first * 256U + second : second * 256U + first);
  };
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t point = unit(at);
    const bool isHigh = point >= 0xD800 && point < 0xDC00 && at + 3 < bytes.size();
    if (isHigh && unit(at + 2) >= 0xDC00 && unit(at + 2) < 0xE000) {
      point = 0x10000 + ((point - 0xD800) << 10U) + (unit(at + 2) - 0xDC00);
      at += 2;
    }
    appendUtf8(text, point >= 0xD800 && point < 0xE000 ? 0xFFFD : point);
  }
  return text;
}

bool isUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = sequenceLength(text.substr(at));
    if (length == 0) {
      return false;
    }
    at += length;
  }
  return true;
}

// Windows-1252 of the bytes 0x80 to 0x9F; 0: a control character
constexpr std::array<std::uint32_t, 32> kWindows = {0x20AC, 0,      0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                                    0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0,      0x017D, 0,
                                                    0,      0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                                    0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0,      0x017E, 0x0178};

struct Signature {
  std::string_view bytes;
  std::string_view kind;
};
using namespace std::string_view_literals;
constexpr std::array kSignatures = {
    Signature{"\x89PNG\r\n"sv, "a PNG picture"},
    Signature{"\xFF\xD8\xFF"sv, "a JPEG picture"},
    Signature{"GIF87a"sv, "a GIF picture"},
    Signature{"GIF89a"sv, "a GIF picture"},
    Signature{"II*\0"sv, "a TIFF picture"},
    Signature{"MM\0*"sv, "a TIFF picture"},
    Signature{"RIFF"sv, "a picture, a sound or a film (RIFF)"},
    Signature{"%PDF-"sv, "a PDF document"},
    Signature{"PK\x03\x04"sv, "a ZIP archive, or a document of an office program"},
    Signature{"\x1F\x8B"sv, "a file compressed with gzip"},
    Signature{"\x28\xB5\x2F\xFD"sv, "a file compressed with zstd"},
    Signature{"7z\xBC\xAF"sv, "a 7z archive"},
    Signature{"Rar!"sv, "a RAR archive"},
    Signature{"glTF"sv, "a mesh (GLB)"},
    Signature{"\x7F"
              "ELF"sv,
              "a program (ELF)"},
    Signature{"MZ\x90"sv, "a program for Windows"},
    Signature{"SQLite format 3"sv, "a database (SQLite)"},
    Signature{"\xD0\xCF\x11\xE0"sv, "a document of an old office program"},
    Signature{"{\\rtf"sv, "a document with formatting (RTF)"},
};

/// Whether half of the bytes are 0, all of them at even places or all at odd ones, as in UTF-16 of plain letters.
bool isUnmarkedUtf16(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    return false;
  }
  const std::string_view start = bytes.substr(0, 2000);
  std::array<std::size_t, 2> zeros{};
  for (std::size_t at = 0; at < start.size(); ++at) {
    zeros[at % 2] += start[at] == '\0' ? 1 : 0;
  }
  const std::size_t most = std::max(zeros[0], zeros[1]);
  // a few letters may have two bytes that are not 0
  return std::min(zeros[0], zeros[1]) == 0 && start.size() >= 8 && most * 20 >= start.size() * 9;
}

}  // namespace

std::string_view withoutByteOrderMark(std::string_view text) {
  return text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text;
}

std::string readableText(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    return readableText(fromUtf16(bytes.substr(2), bytes.front() == '\xFE'));
  }
  bytes = bytes.substr(0, bytes.find('\x1A'));
  if (bytes.find('\r') == std::string_view::npos && bytes.find(kByteOrderMark) == std::string_view::npos) {
    return std::string(bytes);
  }
  std::string text;
  text.reserve(bytes.size());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    if (bytes.substr(at).starts_with(kByteOrderMark)) {
      at += kByteOrderMark.size() - 1;
    } else {
      const bool isAlone = bytes[at] == '\r' && (at + 1 == bytes.size() || bytes[at + 1] != '\n');
      text += isAlone ? '\n' : bytes[at];
    }
  }
  return text;
}

std::string asUtf8(std::string_view bytes) {
  std::string text = readableText(bytes);
  if (isUtf8(text)) {
    return text;
  }
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool isWindows = byte >= 0x80 && byte < 0xA0 && kWindows[byte - 0x80U] != 0;
    appendUtf8(result, isWindows ? kWindows[byte - 0x80U] : byte);
  }
  return result;
}

std::string kindOfNoText(std::string_view bytes) {
  if (isUnmarkedUtf16(bytes)) {
    return "a text in UTF-16 without a byte order mark";
  }
  for (const Signature& signature : kSignatures) {
    if (bytes.starts_with(signature.bytes)) {
      return std::string(signature.kind);
    }
  }
  const bool isUtf16 = bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF");
  // old editors fill the last block of a file behind Ctrl-Z
  const std::string_view text = bytes.substr(0, bytes.find('\x1A'));
  // a stray control character may stand in a text, many do not
  constexpr std::ptrdiff_t kTextBytesPerControl = 50;
  const auto controls = std::count_if(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < '\t' || (byte > '\r' && byte < ' ' && byte != '\x1B');
  });
  const bool isBinary = text.find('\0') != std::string_view::npos || kTextBytesPerControl * controls > std::ssize(text);
  return !isUtf16 && isBinary ? "a binary file" : std::string{};
}

}  // namespace espalier::files
