#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/result.h"

namespace espalier::command {

/// A sweep as an array of Slurm jobs: job k makes slice k of `slices`.
struct SlurmJob {
  std::string plan;
  std::string output;
  std::uint64_t slices = 1;
  std::vector<std::string> options;     // of sbatch, for the jobs of the array
  bool allowsFolderPrograms = false;    // of the sweep
  std::string world{}, stepDuration{};  // of the sweep; empty: not given
};

/// The arrays of a job: first slice and number of jobs of each, at most `limit` jobs an array.
[[nodiscard]] std::vector<std::pair<std::uint64_t, std::uint64_t>> slurmArrays(std::uint64_t slices,
                                                                               std::uint64_t limit);

/// The job script of an array. It needs the variable ESPALIER_OFFSET: the slices before the array.
[[nodiscard]] std::string slurmScript(const SlurmJob& job, const std::string& program);

/// Writes the job script beside the output (NAME.slurm.sh), submits as many arrays as the limit of the cluster
/// (MaxArraySize) asks for, and a job that merges all parts afterwards. Returns their identifiers, the last is of the
/// merging job. Without Slurm the problem says what would have been submitted.
[[nodiscard]] Result<std::vector<std::string>> submitSlurmJob(const SlurmJob& job);

}  // namespace espalier::command
