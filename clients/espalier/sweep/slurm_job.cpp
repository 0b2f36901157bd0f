#include "clients/espalier/sweep/slurm_job.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

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

std::string thisProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? "espalier" : program.string();
}

// the identifier of a submitted job, without the name of the cluster that may follow a `;`
Result<std::string> submit(const std::string& command) {
  const CommandOutput output = outputOf(command);
  if (output.status != 0) {
    return problem(
        "Slurm has refused a job (its message is above): correct the options, as "
        "--job-option=--partition=NAME. The command is " +
        command);
  }
  return output.text.substr(0, output.text.find_first_of(";\n"));
}

std::string mergingScript(const SlurmJob& job, const std::string& program) {
  const std::string stem = fs::path(job.output).replace_extension("").string();
  return "#!/bin/bash\n#SBATCH --job-name=espalier-merge\n#SBATCH --output=" + stem +
         ".slurm-merge.log\nparts=()\nfor k in $(seq " + std::to_string(job.slices) + "); do parts+=(" +
         quotedForShell(stem) + ".part-$k.sqlite); done\nexec " + quotedForShell(program) +
         " sweep merge \"${parts[@]}\" -o " + quotedForShell(job.output) + "\n";
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
         std::to_string(job.slices) + " --workers ${SLURM_CPUS_PER_TASK:-1}" +
         (job.world.empty() ? "" : " --world " + quotedForShell(job.world)) +
         (job.stepDuration.empty() ? "" : " --step-duration " + quotedForShell(job.stepDuration)) +
         (job.allowsFolderPrograms ? " --allow-folder-programs\n" : "\n");
}

Result<std::vector<std::string>> submitSlurmJob(const SlurmJob& job) {
  const std::string stem = fs::path(job.output).replace_extension("").string();
  const std::string script = stem + ".slurm.sh";
  const std::string mergeScript = stem + ".slurm-merge.sh";
  const std::string program = thisProgram();
  for (const auto& [file, text] :
       {std::pair(script, slurmScript(job, program)), std::pair(mergeScript, mergingScript(job, program))}) {
    if (auto mistake = server::writeFileAtomically(file, text)) {
      return problem(*mistake);
    }
  }
  std::vector<std::string> commands;
  const bool isHere = isOnPath("sbatch");
  for (const auto& [first, count] : slurmArrays(job.slices, isHere ? arrayLimit() : 1000)) {
    commands.push_back("sbatch --parsable --array=1-" + std::to_string(count) +
                       " --export=ALL,ESPALIER_OFFSET=" + std::to_string(first - 1) + " " + quotedForShell(script));
  }
  const std::string merging = "sbatch --parsable --dependency=afterok:";
  if (!isHere) {
    std::string wanted;
    for (const std::string& command : commands) {
      wanted += "\n  " + command;
    }
    return problem("Slurm is not here: there is no sbatch on the PATH. The job scripts are '" + script + "' and '" +
                   mergeScript + "'. On the cluster these commands submit the sweep:" + wanted + "\n  " + merging +
                   "JOBS " + quotedForShell(mergeScript));
  }
  std::vector<std::string> jobs;
  std::string all;
  for (const std::string& command : commands) {
    const Result<std::string> submitted = submit(command);
    if (!submitted) {
      return problem(submitted.error());
    }
    jobs.push_back(*submitted);
    all += (all.empty() ? "" : ":") + *submitted;
  }
  const Result<std::string> submitted = submit(merging + all + " " + quotedForShell(mergeScript));
  if (!submitted) {
    return problem(submitted.error());
  }
  jobs.push_back(*submitted);
  return jobs;
}

}  // namespace espalier::command
