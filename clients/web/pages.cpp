#include "clients/web/pages.h"

// The assembler copies the files into the program: C++20 has no way to, and half a megabyte as an array of numbers
// takes seconds to compile.
#define ESPALIER_EMBED(name, file)                                                                  \
  __asm__(".section .rodata\n" #name "Begin:\n.incbin \"" ESPALIER_WEB_FOLDER "/" file "\"\n" #name \
          "End:\n.byte 0\n.previous\n");                                                            \
  extern "C" const char name##Begin[];                                                              \
  extern "C" const char name##End[]

ESPALIER_EMBED(espalierPage, "page.html");
ESPALIER_EMBED(espalierScript, "espalier.js");

namespace espalier::web {

std::string_view serverPage() {
  return {espalierPageBegin, static_cast<std::size_t>(espalierPageEnd - espalierPageBegin)};
}

std::string_view script() {
  return {espalierScriptBegin, static_cast<std::size_t>(espalierScriptEnd - espalierScriptBegin)};
}

}  // namespace espalier::web
