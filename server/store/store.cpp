#include "server/store/store.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <mutex>
#include <system_error>

#include "server/remote/control_group.h"
#include "server/store/compression.h"
#include "server/store/database.h"
#include "server/store/folder_lock.h"
#include "server/store/schema.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// Of the compressed state in one transaction.
constexpr std::size_t kPartBytes = 1'000'000;
/// A part's row is the number of its state times this, and its own number.
constexpr std::int64_t kPartsPerState = 1 << 20;

std::int64_t signedOf(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

}  // namespace

/// One connection for all threads, used for one transaction at a time.
class Store::Implementation {
 public:
  Implementation(std::string folder, Durability durability) : folder_(std::move(folder)), durability_(durability) {}
  ~Implementation() {
    if (log_ >= 0) {
      ::close(log_);
    }
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  std::optional<std::string> open(std::uint64_t maximumBytes);
  /// With the mutex held, or while nobody else knows the database.
  void boundPages(std::uint64_t maximumBytes);

  /// Writes the parts of a state. In the transaction of the last part, `link` makes it the state of a simulation or
  /// checkpoint, and returns the number of the state that it replaces, or 0.
  std::optional<std::string> put(std::string_view state, const std::function<std::int64_t(std::int64_t)>& link);
  State get(std::int64_t state);

  /// Runs `work` in a transaction, which is safe when this returns.
  std::optional<std::string> change(const std::function<void()>& work);
  /// After a failure, `isCommitted` says whether the database has the change all the same: only its safety is unknown.
  std::optional<std::string> change(const std::function<void()>& work, bool& isCommitted);
  /// Runs `work`, which reads.
  std::optional<std::string> look(const std::function<void()>& work);

  /// With the mutex held: nothing refers to the state any more.
  void discard(std::int64_t state) {
    if (state != 0) {
      discarded_.push_back(state);
    }
  }
  /// Removes the parts of discarded states, a transaction each. A failure is left for the next time.
  void sweep();
  [[nodiscard]] std::uint64_t syncCount() const { return groupCommit_.requestCount(); }

  Database database_;
  const std::string folder_;

 private:
  void putPart(std::int64_t state, std::int64_t number, std::string_view bytes);
  /// With the mutex held; clears it.
  std::optional<std::string> problem(const char* what);
  [[nodiscard]] std::string problemText(const char* what, const std::string& reason) const;
  /// Runs `work` in a transaction. `number` receives the number of the commit.
  std::optional<std::string> commit(const std::function<void()>& work, std::uint64_t& number);
  std::optional<std::string> openLog();

  const Durability durability_;
  std::mutex mutex_;
  FolderLock lock_;
  int log_ = -1;  // the write-ahead log, open for forcing it to the disk; -1: not needed
  // SQLite itself forces the log before it moves it into the database
  GroupCommit groupCommit_{[this] { return ::fdatasync(log_) == 0 ? 0 : errno; }};
  std::int64_t lastState_ = 0;
  std::vector<std::int64_t> discarded_;
};

std::optional<std::string> Store::Implementation::problem(const char* what) {
  if (!database_.problem()) {
    return std::nullopt;
  }
  std::string text = problemText(what, *database_.problem());
  database_.clearProblem();
  return text;
}

std::string Store::Implementation::problemText(const char* what, const std::string& reason) const {
  return "the data folder '" + folder_ + "' cannot be " + what + ": " + reason +
         ". Check that its disk has room and can be written, then ask again.";
}

std::optional<std::string> Store::Implementation::open(std::uint64_t maximumBytes) {
  const auto failure = [this](const std::string& reason) {
    return "cannot use the data folder '" + folder_ + "': " + reason +
           ". Give --data a folder that this user may read and write.";
  };
  auto locked = lockFolder(folder_);
  if (!locked) {
    return std::move(locked.error());
  }
  lock_ = std::move(*locked);

  const std::string file = (fs::path(folder_) / kStoreFile).string();
  // SQLite gives the log and its index the rights of the database
  for (const char* suffix : {"", "-wal", "-shm"}) {
    if (const int reason = makePrivate(file + suffix, *suffix == '\0')) {
      return failure(std::generic_category().message(reason));
    }
  }
  database_.open(file);
  if (isOfAnotherProgram(database_)) {
    return "the database '" + file + "' was made by another program. Give --data another folder.";
  }
  if (!migrate(database_)) {
    return "the data folder '" + folder_ + "' was made by a newer Espalier. Use that, or give --data another folder.";
  }
  database_.begin();
  // of simulations that were never saved: nobody can ask for them
  database_.execute("DELETE FROM checkpoints WHERE simulation NOT IN (SELECT id FROM simulations)");
  // parts of states that were being written when the server was killed
  database_.execute(
      "DELETE FROM parts WHERE id / 1048576 NOT IN (SELECT state FROM simulations UNION SELECT state FROM "
      "checkpoints)");
  (void)database_.commit();
  {
    Database::Statement statement(database_, "SELECT max(id) / 1048576 FROM parts");
    lastState_ = statement.next() ? statement.integer(0) : 0;
  }
  boundPages(maximumBytes);
  if (database_.problem()) {
    if (database_.isFileDamaged()) {
      return "the database '" + file + "' is damaged, or it is no database: " + *database_.problem() +
             ". Make a new data folder of a backup (espalier restore FILE NEW-FOLDER), or give --data another folder.";
    }
    return failure(*database_.problem() + " (" + kStoreFile + ")");
  }
  return openLog();
}

void Store::Implementation::boundPages(std::uint64_t maximumBytes) {
  constexpr std::uint64_t kPageBytes = 4096;
  constexpr std::uint64_t kMostPages = 4'294'967'294;  // of a database
  const std::uint64_t pages = maximumBytes == 0 ? kMostPages : std::min(maximumBytes / kPageBytes + 1, kMostPages);
  database_.execute(("PRAGMA max_page_count = " + std::to_string(pages)).c_str());
}

std::optional<std::string> Store::Implementation::openLog() {
  if (durability_ == Durability::Process) {
    return std::nullopt;
  }
  // the log is there: opening the database has written to it, and it stays while the connection lives
  log_ = ::open((fs::path(folder_) / (std::string(kStoreFile) + "-wal")).c_str(), O_RDWR | O_CLOEXEC);
  const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // the names of new files are data of the folder
  const bool isSafe = log_ >= 0 && folder >= 0 && ::fdatasync(log_) == 0 && ::fsync(folder) == 0;
  const int reason = errno;
  if (folder >= 0) {
    ::close(folder);
  }
  return isSafe
             ? std::nullopt
             : std::optional("the disk of the data folder '" + folder_ +
                             "' cannot be asked to keep what is written: " + std::generic_category().message(reason) +
                             ". Use another disk, or durability = \"process\".");
}

std::optional<std::string> Store::Implementation::commit(const std::function<void()>& work, std::uint64_t& number) {
  const std::lock_guard lock(mutex_);
  database_.begin();
  work();
  (void)database_.commit();
  number = groupCommit_.committed();
  return problem("written");
}

std::optional<std::string> Store::Implementation::change(const std::function<void()>& work) {
  bool isCommitted = false;
  return change(work, isCommitted);
}

std::optional<std::string> Store::Implementation::change(const std::function<void()>& work, bool& isCommitted) {
  std::uint64_t number = 0;
  auto failure = commit(work, number);
  isCommitted = !failure;
  if (isCommitted && durability_ == Durability::Power) {
    // without the mutex: others commit meanwhile and share the next request
    if (const int reason = groupCommit_.waitFor(number)) {
      failure = problemText("written safely", std::generic_category().message(reason));
    }
  }
  return failure;
}

std::optional<std::string> Store::Implementation::look(const std::function<void()>& work) {
  const std::lock_guard lock(mutex_);
  work();
  return problem("read");
}

void Store::Implementation::putPart(std::int64_t state, std::int64_t number, std::string_view bytes) {
  Database::Statement insert(database_, "INSERT INTO parts(id, bytes) VALUES(?, ?)");
  insert.bind(1, state * kPartsPerState + number).bindBytes(2, bytes).run();
}

std::optional<std::string> Store::Implementation::put(std::string_view state,
                                                      const std::function<std::int64_t(std::int64_t)>& link) {
  const std::string packed = compress(state);
  std::string_view rest = packed;
  std::int64_t number = 0;
  std::int64_t made = 0;
  {
    const std::lock_guard lock(mutex_);
    made = ++lastState_;
  }
  std::optional<std::string> failure;
  // all parts but the last: nothing refers to them yet
  while (rest.size() > kPartBytes && !failure) {
    std::uint64_t commitNumber = 0;
    failure = commit([&] { putPart(made, number, rest.substr(0, kPartBytes)); }, commitNumber);
    rest.remove_prefix(kPartBytes);
    ++number;
  }
  std::int64_t replaced = 0;
  bool isCommitted = false;
  if (!failure) {
    const auto replace = [&] {
      putPart(made, number, rest);
      replaced = link(made);
      // most states have one part: it goes in the same transaction
      Database::Statement remove(database_, "DELETE FROM parts WHERE id = ?");
      remove.bind(1, replaced * kPartsPerState).run();
    };
    failure = change(replace, isCommitted);
  }
  {
    const std::lock_guard lock(mutex_);
    discard(isCommitted ? replaced : made);
  }
  sweep();
  return failure;
}

void Store::Implementation::sweep() {
  bool isDone = false;
  while (!isDone) {
    const std::lock_guard lock(mutex_);
    if (discarded_.empty()) {
      return;
    }
    const std::int64_t first = discarded_.back() * kPartsPerState;
    std::int64_t part = -1;
    {
      Database::Statement find(database_, "SELECT max(id) FROM parts WHERE id >= ? AND id < ?");
      find.bind(1, first).bind(2, first + kPartsPerState);
      part = find.next() && find.integer(0) != 0 ? find.integer(0) : -1;
    }
    if (part < 0) {
      discarded_.pop_back();
    } else {
      database_.begin();
      {
        Database::Statement remove(database_, "DELETE FROM parts WHERE id = ?");
        remove.bind(1, part).run();
      }
      (void)database_.commit();
    }
    isDone = problem("written").has_value();
  }
}

Store::State Store::Implementation::get(std::int64_t state) {
  const std::int64_t first = state * kPartsPerState;
  std::string packed;
  for (std::int64_t id = first; id >= first;) {
    const auto failure = look([&] {
      Database::Statement read(database_, "SELECT bytes FROM parts WHERE id = ?");
      read.bind(1, id);
      if (read.next()) {
        packed.append(read.bytes(0));
        ++id;
      } else {
        id = -1;
      }
    });
    if (failure) {
      return {{}, *failure};
    }
  }
  auto bytes = decompress(packed, usableMemoryBytes());
  if (!bytes) {
    return {{}, "its state in the data folder is damaged"};
  }
  return {std::move(*bytes), {}};
}

Store::Store(std::string folder, std::uint64_t maximumBytes, Durability durability)
    : folder_(std::move(folder)), maximumBytes_(maximumBytes), durability_(durability) {}

Store::~Store() = default;

std::optional<std::string> Store::open() {
  if (!isKept()) {
    return std::nullopt;
  }
  implementation_ = std::make_unique<Implementation>(folder_, durability_);
  auto problem = implementation_->open(maximumBytes_);
  if (problem) {
    implementation_.reset();
  }
  return problem;
}

namespace {

/// The row (id, record, step, owner) that a statement is at.
Store::Entry entryOf(const Database::Statement& row) {
  return {std::string(row.text(0)), std::string(row.text(1)), static_cast<std::uint64_t>(row.integer(2)),
          std::string(row.text(3))};
}

}  // namespace

std::optional<std::string> Store::setMaximumBytes(std::uint64_t maximumBytes) {
  return implementation_ == nullptr ? std::nullopt
                                    : implementation_->look([&] { implementation_->boundPages(maximumBytes); });
}

tl::expected<std::vector<Store::Entry>, std::string> Store::simulations() const {
  std::vector<Entry> entries;
  if (implementation_ == nullptr) {
    return entries;
  }
  const auto failure = implementation_->look([&] {
    Database::Statement read(implementation_->database_, "SELECT id, record, step, owner FROM simulations ORDER BY id");
    while (read.next()) {
      entries.push_back(entryOf(read));
    }
  });
  if (failure) {
    return tl::unexpected(*failure);
  }
  return entries;
}

tl::expected<Store::Entry, std::string> Store::simulation(const std::string& id) const {
  tl::expected<Entry, std::string> entry = tl::unexpected("there is no simulation '" + id + "' in the data folder.");
  if (implementation_ == nullptr) {
    return entry;
  }
  const auto failure = implementation_->look([&] {
    Database::Statement read(implementation_->database_,
                             "SELECT id, record, step, owner FROM simulations WHERE id = ?");
    if (read.bind(1, id).next()) {
      entry = entryOf(read);
    }
  });
  if (failure) {
    return tl::unexpected(*failure);
  }
  return entry;
}

std::optional<std::string> Store::save(const Entry& entry, std::string_view state) {
  if (implementation_ == nullptr) {
    return std::nullopt;
  }
  return implementation_->put(state, [&](std::int64_t made) {
    Database& database = implementation_->database_;
    Database::Statement old(database, "SELECT state FROM simulations WHERE id = ?");
    const std::int64_t replaced = old.bind(1, entry.id).next() ? old.integer(0) : 0;
    Database::Statement write(database,
                              "INSERT OR REPLACE INTO simulations(id, record, step, state, owner) "
                              "VALUES(?, ?, ?, ?, ?)");
    write.bind(1, entry.id).bind(2, entry.record).bind(3, signedOf(entry.step)).bind(4, made);
    write.bind(5, entry.owner).run();
    return replaced;
  });
}

std::optional<std::string> Store::saveState(const std::string& simulation, std::uint64_t step, std::string_view state) {
  if (implementation_ == nullptr) {
    return std::nullopt;
  }
  return implementation_->put(state, [&](std::int64_t made) {
    Database& database = implementation_->database_;
    Database::Statement old(database, "SELECT state FROM simulations WHERE id = ?");
    const std::int64_t replaced = old.bind(1, simulation).next() ? old.integer(0) : 0;
    Database::Statement write(database, "UPDATE simulations SET step = ?, state = ? WHERE id = ?");
    write.bind(1, signedOf(step)).bind(2, made).bind(3, simulation).run();
    return replaced;
  });
}

Store::State Store::readState(const std::string& simulation) const {
  std::int64_t state = 0;
  if (implementation_ != nullptr) {
    const auto failure = implementation_->look([&] {
      Database::Statement find(implementation_->database_, "SELECT state FROM simulations WHERE id = ?");
      state = find.bind(1, simulation).next() ? find.integer(0) : 0;
    });
    if (failure) {
      return {{}, *failure};
    }
  }
  return state == 0 ? State{{}, "it has no state in the data folder"} : implementation_->get(state);
}

std::optional<std::string> Store::remove(const std::string& simulation) {
  if (implementation_ == nullptr) {
    return std::nullopt;
  }
  std::vector<std::int64_t> states;
  auto failure = implementation_->change([&] {
    Database& database = implementation_->database_;
    Database::Statement find(database,
                             "SELECT state FROM simulations WHERE id = ?1 "
                             "UNION SELECT state FROM checkpoints WHERE simulation = ?1");
    find.bind(1, simulation);
    while (find.next()) {
      states.push_back(find.integer(0));
    }
    Database::Statement(database, "DELETE FROM simulations WHERE id = ?").bind(1, simulation).run();
    Database::Statement(database, "DELETE FROM checkpoints WHERE simulation = ?").bind(1, simulation).run();
  });
  if (!failure) {
    (void)implementation_->look([&] {
      for (const std::int64_t state : states) {
        implementation_->discard(state);
      }
    });
    implementation_->sweep();
  }
  return failure;
}

std::optional<std::string> Store::saveCheckpoint(const std::string& simulation, const std::string& name,
                                                 std::uint64_t step, std::string_view state) {
  if (implementation_ == nullptr) {
    return std::nullopt;
  }
  return implementation_->put(state, [&](std::int64_t made) {
    Database& database = implementation_->database_;
    Database::Statement old(database, "SELECT state FROM checkpoints WHERE simulation = ? AND name = ?");
    const std::int64_t replaced = old.bind(1, simulation).bind(2, name).next() ? old.integer(0) : 0;
    Database::Statement write(
        database, "INSERT OR REPLACE INTO checkpoints(simulation, name, step, state, bytes) VALUES(?, ?, ?, ?, ?)");
    write.bind(1, simulation).bind(2, name).bind(3, signedOf(step)).bind(4, made);
    write.bind(5, signedOf(state.size())).run();
    return replaced;
  });
}

std::vector<Store::Checkpoint> Store::checkpoints(const std::string& simulation) const {
  std::vector<Checkpoint> all;
  if (implementation_ != nullptr) {
    (void)implementation_->look([&] {
      Database::Statement read(implementation_->database_,
                               "SELECT name, step, bytes FROM checkpoints WHERE simulation = ? ORDER BY name");
      read.bind(1, simulation);
      while (read.next()) {
        all.push_back({std::string(read.text(0)), static_cast<std::uint64_t>(read.integer(1)),
                       static_cast<std::uint64_t>(read.integer(2))});
      }
    });
  }
  return all;
}

Store::State Store::readCheckpoint(const std::string& simulation, const std::string& name) const {
  if (implementation_ == nullptr) {
    return {{}, "this server keeps no checkpoints. Start it with --data DIR, or restore a snapshot"};
  }
  std::int64_t state = 0;
  const auto failure = implementation_->look([&] {
    Database::Statement find(implementation_->database_,
                             "SELECT state FROM checkpoints WHERE simulation = ? AND name = ?");
    state = find.bind(1, simulation).bind(2, name).next() ? find.integer(0) : 0;
  });
  if (failure) {
    return {{}, *failure};
  }
  return state == 0
             ? State{{},
                     "there is no checkpoint '" + name + "'; simulation.get with \"what\":\"checkpoints\" lists them"}
             : implementation_->get(state);
}

std::optional<std::string> Store::saveModel(const std::string& model, std::string_view text) {
  if (implementation_ == nullptr) {
    return std::nullopt;
  }
  return implementation_->change([&] {
    Database::Statement write(implementation_->database_, "INSERT OR REPLACE INTO models(id, text) VALUES(?, ?)");
    write.bind(1, model).bind(2, text).run();
  });
}

std::vector<std::pair<std::string, std::string>> Store::models() const {
  std::vector<std::pair<std::string, std::string>> all;
  if (implementation_ != nullptr) {
    (void)implementation_->look([&] {
      Database::Statement read(implementation_->database_, "SELECT id, text FROM models");
      while (read.next()) {
        all.emplace_back(read.text(0), read.text(1));
      }
    });
  }
  return all;
}

std::uint64_t Store::bytes() const {
  std::uint64_t sum = 0;
  for (const char* suffix : {"", "-wal"}) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(fs::path(folder_) / (std::string(kStoreFile) + suffix), error);
    sum += error || folder_.empty() ? 0 : size;
  }
  return sum;
}

std::uint64_t Store::syncCount() const {
  return implementation_ == nullptr ? 0 : implementation_->syncCount();
}

}  // namespace espalier::server
