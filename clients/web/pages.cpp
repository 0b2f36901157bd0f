#include "clients/web/pages.h"

// The assembler copies the files into the program. C++20 cannot embed files, and an array of 600,000 numbers compiles
// for seconds.
#define ESPALIER_EMBED(name, file)                                                                         \
  __asm__(".section .rodata\n" #name "Begin:\n.incbin \"" file "\"\n" #name "End:\n.byte 0\n.previous\n"); \
  extern "C" const char name##Begin[];                                                                     \
  extern "C" const char name##End[]

ESPALIER_EMBED(espalierPage, ESPALIER_WEB_PAGE);
ESPALIER_EMBED(espalierScript, ESPALIER_WEB_SCRIPT);
ESPALIER_EMBED(espalierPacked, ESPALIER_WEB_PACKED);
ESPALIER_EMBED(espalierStyle, ESPALIER_WEB_STYLE);

namespace espalier::web {

std::string_view serverPage() {
  return {espalierPageBegin, static_cast<std::size_t>(espalierPageEnd - espalierPageBegin)};
}

std::string_view script() {
  return {espalierScriptBegin, static_cast<std::size_t>(espalierScriptEnd - espalierScriptBegin)};
}

std::string_view packedScript() {
  return {espalierPackedBegin, static_cast<std::size_t>(espalierPackedEnd - espalierPackedBegin)};
}

std::string_view style() {
  return {espalierStyleBegin, static_cast<std::size_t>(espalierStyleEnd - espalierStyleBegin)};
}

}  // namespace espalier::web
