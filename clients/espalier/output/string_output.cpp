#include "clients/espalier/output/string_output.h"

#include <cstdio>

#include "engine/derivation/state/string_text.h"

namespace espalier::command {
namespace {

class StandardOutput final : public core::ByteSink {
 public:
  void write(std::string_view bytes) override { std::fwrite(bytes.data(), 1, bytes.size(), stdout); }
};

}  // namespace

void printString(derivation::TextWriter& writer, const language::Program& program,
                 const derivation::ModuleString& string) {
  StandardOutput sink;
  writer.write(sink, program, string, derivation::numberStyle(program.compatibility));
  std::fputc('\n', stdout);
}

}  // namespace espalier::command
