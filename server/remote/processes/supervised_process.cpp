#include "server/remote/processes/supervised_process.h"

#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/turtle/field.h"
#include "engine/turtle/guarded_call.h"

namespace espalier::server {
namespace {

using turtle::EnvironmentError;
using Instance = std::shared_ptr<turtle::EnvironmentProcess>;

/// The working data of a thread: everything in it stays alive until the thread is done, however long that takes.
struct Room {
  Instance process;
  std::string name;
  turtle::QueryBatch queries;
  turtle::ReplyBatch replies;

  std::mutex mutex;
  std::condition_variable changed;
  // with the mutex held
  std::optional<std::string> before;                           // the state before the call; nothing: not known yet
  std::function<std::optional<EnvironmentError>(Room&)> task;  // empty: nothing to do
  std::optional<EnvironmentError> error;
  bool isDone = false;
  bool hasThrown = false;
  bool isLeft = false;  // the caller does not wait for it any more
};

void work(const std::shared_ptr<Room>& room) {
  std::unique_lock lock(room->mutex);
  while (true) {
    room->changed.wait(lock, [&] { return room->task || room->isLeft; });
    if (!room->task) {
      return;
    }
    const auto task = std::exchange(room->task, nullptr);
    lock.unlock();
    bool isThrown = true;
    auto error = turtle::guardedCall(room->name, [&] {
      auto answer = task(*room);
      isThrown = false;
      return answer;
    });
    lock.lock();
    room->error = std::move(error);
    room->hasThrown = isThrown;
    room->isDone = true;
    room->changed.notify_all();
  }
}

class SupervisedProcess final : public turtle::EnvironmentProcess {
 public:
  SupervisedProcess(std::unique_ptr<turtle::EnvironmentProcess> process, Supervision supervision)
      : supervision_(std::move(supervision)), description_(process->describe()) {
    enter(std::move(process));
  }
  SupervisedProcess(const SupervisedProcess&) = delete;
  SupervisedProcess& operator=(const SupervisedProcess&) = delete;
  ~SupervisedProcess() override { leave(); }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return description_; }

  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    // opening makes any state anew
    state_.reset();
    if (!room_ && !enter(supervision_.again())) {
      return gone();
    }
    context_ = context;
    auto error = call("opening", [context](Room& room) {
      auto problem = room.process->open(context);
      if (!problem) {
        keepState(room, room.process->describe().isStateful);
      }
      return problem;
    });
    if (error) {
      return error;
    }
    description_ = room_->process->describe();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    if (auto error = comeBack()) {
      return error;
    }
    // the thread may need them longer than the caller has them
    room_->queries = queries;
    room_->replies.prepare(queries);
    auto error = call("step " + std::to_string(queries.step + 1), [isStateful = description_.isStateful](Room& room) {
      keepState(room, isStateful);
      return room.process->step(room.queries, room.replies);
    });
    if (error) {
      return error;
    }
    if (auto problem = requireFinite()) {
      // it has advanced: its state goes back
      retire();
      return problem;
    }
    std::swap(replies.values, room_->replies.values);
    std::swap(replies.isSet, room_->replies.isSet);
    replies.answeredCount = room_->replies.answeredCount;
    replies.surplusCount = room_->replies.surplusCount;
    std::swap(replies.notes, room_->replies.notes);
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t step) override {
    if (auto error = comeBack()) {
      return error;
    }
    return call("step " + std::to_string(step + 1), [step, isStateful = description_.isStateful](Room& room) {
      keepState(room, isStateful);
      return room.process->tick(step);
    });
  }

  [[nodiscard]] std::string save() const override {
    return room_ ? room_->process->save() : state_.value_or(std::string());
  }

  [[nodiscard]] std::optional<EnvironmentError> restore(std::string_view state) override {
    if (!room_) {
      state_ = std::string(state);
      return comeBack();
    }
    return room_->process->restore(state);
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    return room_ ? room_->process->fields() : std::vector<turtle::Field>{};
  }

 private:
  static void keepState(Room& room, bool isStateful) {
    std::string state = isStateful ? room.process->save() : std::string();
    const std::lock_guard lock(room.mutex);
    room.before = std::move(state);
  }

  bool enter(std::unique_ptr<turtle::EnvironmentProcess> process) {
    if (!process) {
      return false;
    }
    room_ = std::make_shared<Room>();
    room_->process = std::move(process);
    room_->name = description_.name;
    thread_ = std::thread(work, room_);
    return true;
  }

  /// Ends the thread and the instance, which is not in a call.
  void leave() {
    if (!room_) {
      return;
    }
    {
      const std::lock_guard lock(room_->mutex);
      room_->isLeft = true;
    }
    room_->changed.notify_all();
    thread_.join();
    room_.reset();
  }

  /// Keeps the state from before the call, and gives the instance up.
  void retire() {
    state_ = std::move(room_->before);
    leave();
  }

  /// Runs a task on the thread, for at most the step's time.
  [[nodiscard]] std::optional<EnvironmentError> call(const std::string& during,
                                                     std::function<std::optional<EnvironmentError>(Room&)> task) {
    std::unique_lock lock(room_->mutex);
    room_->isDone = false;
    room_->before.reset();
    room_->task = std::move(task);
    room_->changed.notify_all();
    if (!room_->changed.wait_for(lock, supervision_.stepTimeout, [this] { return room_->isDone; })) {
      // the thread goes on alone: it owns its data
      room_->isLeft = true;
      state_ = room_->before;
      lock.unlock();
      thread_.detach();
      room_.reset();
      return EnvironmentError{
          "environment '" + description_.name + "' did not finish " + during + " within " +
              std::to_string(supervision_.stepTimeout.count()) +
              " ms. It runs inside this program and cannot be stopped from outside: that call is left alone, and a new "
              "instance answers from now on. Correct it, give it longer, or run it as a program of its own.",
          true};
    }
    auto error = std::move(room_->error);
    const bool hasThrown = room_->hasThrown;
    lock.unlock();
    if (hasThrown) {
      retire();
    }
    return error;
  }

  /// A new instance with the kept state, when the last one was given up.
  [[nodiscard]] std::optional<EnvironmentError> comeBack() {
    if (room_) {
      return std::nullopt;
    }
    if (description_.isStateful && !state_) {
      return EnvironmentError{"environment '" + description_.name +
                                  "' was given up while it saved its state. Restore a snapshot, or rewind.",
                              false};
    }
    if (!enter(supervision_.again())) {
      return gone();
    }
    auto error = call("opening again", [context = context_, state = state_.value_or(std::string()),
                                        isStateful = description_.isStateful](Room& room) {
      {
        const std::lock_guard lock(room.mutex);
        room.before = state;
      }
      auto problem = room.process->open(context);
      if (!problem && isStateful) {
        problem = room.process->restore(state);
      }
      return problem;
    });
    // an instance that does not open is not there
    if (error && room_) {
      retire();
    }
    return error;
  }

  [[nodiscard]] EnvironmentError gone() const {
    return {"environment '" + description_.name + "' was given up and cannot be made anew. Start the run again.",
            false};
  }

  [[nodiscard]] std::optional<EnvironmentError> requireFinite() const {
    const turtle::ReplyBatch& replies = room_->replies;
    const turtle::QueryBatch& queries = room_->queries;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      for (std::uint64_t k = queries.parameterOffset[query]; k < queries.parameterOffset[query + 1]; ++k) {
        if (replies.isSet[k] != 0 && !std::isfinite(replies.values[k])) {
          std::string value;
          core::appendNumber(value, replies.values[k], core::NumberStyle::Shortest);
          return EnvironmentError{"environment '" + description_.name + "' answered " + value + " for parameter " +
                                      std::to_string(k - queries.parameterOffset[query] + 1) + " of query " +
                                      std::to_string(query) + " (plant " + std::to_string(queries.plant[query]) +
                                      ", module " + std::to_string(queries.module[query]) +
                                      "). Replies must be finite numbers: correct the environment.",
                                  false};
        }
      }
    }
    return std::nullopt;
  }

  Supervision supervision_;
  turtle::EnvironmentDescription description_;
  turtle::EnvironmentContext context_;
  std::shared_ptr<Room> room_;        // null: the instance was given up
  std::thread thread_;                // works in room_
  std::optional<std::string> state_;  // while there is no instance: the one it had; nothing: not known
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> supervised(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                       Supervision supervision) {
  return std::make_unique<SupervisedProcess>(std::move(process), std::move(supervision));
}

}  // namespace espalier::server
