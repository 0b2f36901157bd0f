#include "tests/clients/program_run.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::test {

ProgramRun runProgram(const std::string& arguments, const std::string& folder) {
  const TemporaryFolder streams;
  const std::string command = "cd '" + folder + "' && '" + buildFolder() + "/bin/espalier' " + arguments + " >'" +
                              streams.path() + "/output' 2>'" + streams.path() + "/errors' </dev/null";
  const int status = std::system(command.c_str());
  ProgramRun run;
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  run.output = streams.read("output");
  run.errors = streams.read("errors");
  return run;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "espalier-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw std::runtime_error("no temporary folder can be made");
  }
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void TemporaryFolder::write(const std::string& name, const std::string& text) const {
  const std::filesystem::path file = std::filesystem::path(path_) / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

std::string TemporaryFolder::read(const std::string& name) const {
  return readFile(path_ + "/" + name).value_or("");
}

}  // namespace espalier::test
