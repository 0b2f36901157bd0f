#include "engine/turtle/export/mesh/mesh_work.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace espalier::turtle {

namespace {

constexpr std::size_t kTaskMeshes = 8;
constexpr std::size_t kTasksPerThread = 2;  // that may be held whatever their size
// So much may wait while a thread writes the indices of a long piece of a file, so that the others have work. Mostly
// few tasks wait: the memory that was touched last is used again, and stays in the cache.
constexpr std::size_t kHeldBytes = 8 << 20;

/// Meshes that one thread makes and spells one after the other.
struct MeshTask {
  std::size_t first = 0;
  std::vector<Mesh> meshes = std::vector<Mesh>(kTaskMeshes);  // the first `count` of them
  std::size_t count = 0;
  std::vector<std::uint64_t> numbers;                // by mesh
  std::vector<std::optional<std::string>> problems;  // by mesh
  std::string bytes;                                 // of all meshes
  std::vector<std::size_t> ends;                     // in `bytes`, by mesh

  void make(const MeshWork& work) {
    problems.clear();
    bytes.clear();
    for (std::size_t k = 0; k < count; ++k) {
      meshes[k].clear();
      problems.push_back(work.make(first + k, meshes[k]));
    }
  }

  void number(const MeshWork& work) {
    numbers.assign(count, 0);
    for (std::size_t k = 0; work.number && k < count && !problems[k]; ++k) {
      numbers[k] = work.number(first + k, meshes[k]);
    }
  }

  void spell(const MeshWork& work) {
    ends.assign(count, 0);
    for (std::size_t k = 0; work.spell && k < count && !problems[k]; ++k) {
      work.spell(first + k, meshes[k], numbers[k], bytes);
      ends[k] = bytes.size();
    }
  }

  /// About; of the meshes, and of the bytes when they are spelled.
  [[nodiscard]] std::size_t heldBytes() const {
    std::size_t sum = bytes.size();
    for (std::size_t k = 0; k < count; ++k) {
      const Mesh& mesh = meshes[k];
      sum += mesh.positions.size() * (2 * sizeof(core::Vec3) + sizeof(mesh.coordinates[0])) +
             mesh.vertexSegments.size() * sizeof(mesh.vertexSegments[0]) + mesh.faces.size() * sizeof(mesh.faces[0]);
    }
    return sum;
  }

  [[nodiscard]] std::optional<std::string> use(const MeshWork& work) const {
    std::size_t begin = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (problems[k]) {
        return problems[k];
      }
      if (auto problem = work.use(first + k, meshes[k], std::string_view(bytes).substr(begin, ends[k] - begin))) {
        return problem;
      }
      begin = ends[k];
    }
    return std::nullopt;
  }
};

/// Tasks on their way from `make` to `use`. Each thread takes the piece of work that brings the oldest task forward. It
/// waits only when nothing can be done, or when too much is held.
class MeshPipeline {
 public:
  MeshPipeline(std::size_t meshCount, const MeshWork& work, unsigned threads)
      : meshCount_(meshCount),
        taskCount_((meshCount + kTaskMeshes - 1) / kTaskMeshes),
        work_(work),
        freelyHeld_(threads == 1 ? 1 : threads * kTasksPerThread) {}

  /// To be called by every thread. Returns when all tasks are used or one has failed. Throws what the work throws.
  void help() {
    std::unique_lock lock(mutex_);
    try {
      while (used_ < taskCount_ && !isStopped_) {
        takePiece(lock);
      }
    } catch (...) {
      if (!lock.owns_lock()) {
        lock.lock();
      }
      stop();
      throw;
    }
  }

  /// The first sentence; to be called when `help` has returned in all threads.
  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }

 private:
  struct Slot {
    MeshTask task;
    std::size_t heldBytes = 0;
    bool isMade = false;
    bool isSpelled = false;
  };

  [[nodiscard]] Slot& slotOf(std::size_t task) { return *slots_[task - used_]; }
  [[nodiscard]] bool mayMake() const {
    return toMake_ < taskCount_ && (slots_.size() < freelyHeld_ || heldBytes_ < kHeldBytes);
  }

  // does one piece of work; when there is none, waits until another thread has done one
  void takePiece(std::unique_lock<std::mutex>& lock) {
    if (!isUsing_ && used_ < toSpell_ && slotOf(used_).isSpelled) {
      use(lock);
    } else if (toSpell_ < toNumber_) {
      spell(lock);
    } else if (mayMake()) {
      make(lock);
    } else {
      changed_.wait(lock);
      return;
    }
    changed_.notify_all();
  }

  void make(std::unique_lock<std::mutex>& lock) {
    if (free_.empty()) {
      free_.push_back(std::make_unique<Slot>());
    }
    slots_.push_back(std::move(free_.back()));
    free_.pop_back();
    const std::size_t number = toMake_++;
    Slot& slot = *slots_.back();
    slot.isMade = slot.isSpelled = false;
    lock.unlock();
    slot.task.first = number * kTaskMeshes;
    slot.task.count = std::min(kTaskMeshes, meshCount_ - slot.task.first);
    slot.task.make(work_);
    lock.lock();
    count(slot);
    slot.isMade = true;
    // those whose turn it is
    for (; toNumber_ < toMake_ && slotOf(toNumber_).isMade; ++toNumber_) {
      slotOf(toNumber_).task.number(work_);
    }
  }

  void spell(std::unique_lock<std::mutex>& lock) {
    Slot& slot = slotOf(toSpell_++);
    lock.unlock();
    slot.task.spell(work_);
    lock.lock();
    count(slot);
    slot.isSpelled = true;
  }

  void use(std::unique_lock<std::mutex>& lock) {
    Slot& slot = slotOf(used_);
    isUsing_ = true;
    lock.unlock();
    auto problem = slot.task.use(work_);
    lock.lock();
    isUsing_ = false;
    heldBytes_ -= slot.heldBytes;
    slot.heldBytes = 0;
    free_.push_back(std::move(slots_.front()));
    slots_.pop_front();
    ++used_;
    if (problem) {
      problem_ = std::move(problem);
      stop();
    }
  }

  // what a task holds now
  void count(Slot& slot) {
    heldBytes_ -= slot.heldBytes;
    slot.heldBytes = slot.task.heldBytes();
    heldBytes_ += slot.heldBytes;
  }

  void stop() {
    isStopped_ = true;
    changed_.notify_all();
  }

  const std::size_t meshCount_;
  const std::size_t taskCount_;
  const MeshWork& work_;
  const std::size_t freelyHeld_;  // tasks
  std::mutex mutex_;              // of everything below; a task belongs to the thread that makes, spells or uses it
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Slot>> slots_;  // of the tasks from `used_` to `toMake_`
  std::vector<std::unique_ptr<Slot>> free_;  // the last one was used last
  std::size_t heldBytes_ = 0;                // of the tasks that wait, made or spelled
  std::size_t toMake_ = 0;                   // the tasks below it are made, or a thread makes them
  std::size_t toNumber_ = 0;                 // the tasks below it are numbered
  std::size_t toSpell_ = 0;                  // the tasks below it are spelled, or a thread spells them
  std::size_t used_ = 0;                     // the tasks below it are used
  bool isUsing_ = false;                     // a thread uses the task `used_`
  bool isStopped_ = false;
  std::optional<std::string> problem_;
};

}  // namespace

std::optional<std::string> forMeshes(core::WorkerTeam& team, std::size_t count, const MeshWork& work) {
  MeshPipeline pipeline(count, work, team.size());
  team.onEveryWorker([&](unsigned) { pipeline.help(); });
  return pipeline.problem();
}

}  // namespace espalier::turtle
