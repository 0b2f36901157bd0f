#include "clients/espalier/sweep/slurm_job.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "clients/espalier/messages.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

std::string quotedForShell(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    quoted += c == '\'' ? "'\\''" : std::string(1, c);
  }
  return quoted + "'";
}

/// Standard output and exit status of a command of the shell.
struct CommandOutput {
  std::string text;
  int status = -1;
};

CommandOutput outputOf(const std::string& command) {
  CommandOutput output;
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) {
    return output;
  }
  char part[1000];
  while (const std::size_t count = std::fread(part, 1, sizeof part, pipe)) {
    output.text.append(part, count);
  }
  const int status = ::pclose(pipe);
  output.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return output;
}

bool isOnPath(const std::string& program) {
  return outputOf("command -v " + program + " 2>/dev/null").status == 0;
}

// how many jobs an array may have: an index is below MaxArraySize
std::uint64_t arrayLimit() {
  const CommandOutput found = outputOf("scontrol show config 2>/dev/null | sed -n 's/^MaxArraySize *= *//p'");
  const std::uint64_t size = std::strtoull(found.text.c_str(), nullptr, 10);
  constexpr std::uint64_t kUsual = 1001;
  return std::max<std::uint64_t>(size == 0 ? kUsual : size, 2) - 1;
}

std::string partName(const SlurmJob& job, const std::string& number) {
  return fs::path(job.output).replace_extension("").string() + ".part-" + number + ".sqlite";
}

std::string thisProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? "espalier" : program.string();
}

}  // namespace

std::vector<std::pair<std::uint64_t, std::uint64_t>> slurmArrays(std::uint64_t slices, std::uint64_t limit) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> arrays;
  for (std::uint64_t first = 1; first <= slices; first += limit) {
    arrays.emplace_back(first, std::min(limit, slices - first + 1));
  }
  return arrays;
}

std::string slurmScript(const SlurmJob& job, const std::string& program) {
  const std::string stem = fs::path(job.output).replace_extension("").string();
  std::string text = "#!/bin/bash\n#SBATCH --job-name=espalier-sweep\n#SBATCH --output=" + stem + ".slurm-%A-%a.log\n";
  for (const std::string& option : job.options) {
    text += "#SBATCH " + option + "\n";
  }
  return text + "k=$((${ESPALIER_OFFSET:-0} + SLURM_ARRAY_TASK_ID))\nexec " + quotedForShell(program) + " sweep " +
         quotedForShell(job.plan) + " -o " + quotedForShell(stem) + ".part-$k.sqlite --slice $k/" +
         std::to_string(job.slices) + " --workers ${SLURM_CPUS_PER_TASK:-1}\n";
}

std::optional<std::string> submitSlurmJob(const SlurmJob& job) {
  const std::string stem = fs::path(job.output).replace_extension("").string();
  const std::string script = stem + ".slurm.sh";
  const std::string program = thisProgram();
  if (auto problem = server::writeFileAtomically(script, slurmScript(job, program))) {
    return problem;
  }
  const bool isHere = isOnPath("sbatch");
  std::string wanted;
  std::string dependency;
  for (const auto& [first, count] : slurmArrays(job.slices, isHere ? arrayLimit() : 1000)) {
    const std::string command = "sbatch --parsable --array=1-" + std::to_string(count) +
                                " --export=ALL,ESPALIER_OFFSET=" + std::to_string(first - 1) + " " +
                                quotedForShell(script);
    wanted += "\n  " + command;
    if (!isHere) {
      continue;
    }
    const CommandOutput submitted = outputOf(command);
    if (submitted.status != 0) {
      return "Slurm has refused the jobs (its message is above): correct the options, as --job-option=--partition=NAME";
    }
    // the number of the job, perhaps with a `;` and the name of the cluster
    const std::string id = submitted.text.substr(0, submitted.text.find_first_of(";\n"));
    dependency += ":" + id;
    std::printf("%s\n", id.c_str());
  }
  std::string parts;
  for (std::uint64_t slice = 1; slice <= job.slices && job.slices <= 1000; ++slice) {
    parts += " " + quotedForShell(partName(job, std::to_string(slice)));
  }
  if (job.slices > 1000) {
    parts = " " + quotedForShell(stem) + ".part-*.sqlite";
  }
  const std::string merge = "#!/bin/bash\n#SBATCH --job-name=espalier-merge\n#SBATCH --output=" + stem +
                            ".slurm-merge.log\nexec " + quotedForShell(program) + " sweep merge" + parts + " -o " +
                            quotedForShell(job.output) + "\n";
  const std::string mergeScript = stem + ".slurm-merge.sh";
  if (auto problem = server::writeFileAtomically(mergeScript, merge)) {
    return problem;
  }
  wanted += "\n  sbatch --dependency=afterok:JOBS " + quotedForShell(mergeScript);
  if (!isHere) {
    return "Slurm is not here: there is no sbatch on the PATH. The job scripts are '" + script + "' and '" +
           mergeScript + "'. On the cluster these commands submit the sweep:" + wanted;
  }
  const CommandOutput submitted =
      outputOf("sbatch --parsable --dependency=afterok" + dependency + " " + quotedForShell(mergeScript));
  if (submitted.status != 0) {
    return "Slurm has refused the job that merges the parts: run " + mergeScript +
           " yourself when the others have ended";
  }
  std::printf("%s", submitted.text.c_str());
  printNote("submitted " + std::to_string(job.slices) + " jobs and the one that merges their parts into '" +
            job.output + "'");
  return std::nullopt;
}

}  // namespace espalier::command
