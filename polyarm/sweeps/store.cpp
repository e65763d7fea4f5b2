#include "polyarm/sweeps/store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "polyarm/base/text.hpp"
#include "polyarm/base/there.hpp"

namespace polyarm::sweeps {

namespace fs = std::filesystem;

namespace {

constexpr int kBusy_ms = 10'000;

/// A prepared statement. Throws Error("bad-results") for each failure.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& text) : database_(database) {
    if (::sqlite3_prepare_v2(database, text.c_str(), -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { ::sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  void bind(int index, const std::string& text) {
    if (::sqlite3_bind_text(statement_, index, text.c_str(), static_cast<int>(text.size()),
                            SQLITE_TRANSIENT) != SQLITE_OK)
      fail();
  }
  void bind(int index, const std::optional<double>& number) {
    const int code =
        number ? ::sqlite3_bind_double(statement_, index, *number) : ::sqlite3_bind_null(statement_, index);
    if (code != SQLITE_OK) fail();
  }
  /// True if there is a row.
  bool step() {
    const int code = ::sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }
  void reset() { ::sqlite3_reset(statement_); }
  std::string text(int column) const {
    const auto* text = reinterpret_cast<const char*>(::sqlite3_column_text(statement_, column));
    return text ? text : "";
  }
  std::optional<double> number(int column) const {
    if (::sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nullopt;
    return ::sqlite3_column_double(statement_, column);
  }

 private:
  [[noreturn]] void fail() const {
    throw Error("bad-results",
                fmt::format("{}: {}", ::sqlite3_db_filename(database_, "main"), ::sqlite3_errmsg(database_)),
                "is the disk full, or is this no file of results? move it away to begin anew");
  }

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

std::string names_of_columns() {
  std::vector<std::string> out;
  for (const Column& column : columns()) out.push_back(column.name);
  return join(out, ", ");
}

std::string schema() {
  std::vector<std::string> out;
  for (const Column& column : columns())
    out.push_back(column.name + (column.text ? " TEXT NOT NULL" : " REAL") +
                  (column.name == "key" ? " PRIMARY KEY" : ""));
  return join(out, ", ");
}

Row row_at(const Statement& statement) {
  Row out;
  int index = 0;
  for (const Column& column : columns()) {
    if (column.text)
      out.*column.text = statement.text(index++);
    else
      out.*column.number = statement.number(index++);
  }
  return out;
}

/// Holds the lock of a writer as long as it lives. A record lock: processes that are forked do not inherit
/// it, and it works on NFS.
class Lock {
 public:
  explicit Lock(const fs::path& results) {
    const std::string file = results.string() + ".lock";
    descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0)
      throw Error("unwritable", file + " cannot be written: " + std::strerror(errno), "say --out FOLDER");
    struct flock whole = {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    if (::fcntl(descriptor_, F_SETLK, &whole) == 0) return;
    ::close(descriptor_);
    throw Error("busy", "another polyarm sweep writes to " + results.string(),
                "wait for it or end it; --show works meanwhile");
  }
  ~Lock() { ::close(descriptor_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int descriptor_;
};

}  // namespace

struct Store::Work {
  std::optional<Lock> lock;
  sqlite3* database = nullptr;
  std::optional<Statement> has, find;  ///< prepared once: a sweep asks for each of its variants

  ~Work() { ::sqlite3_close_v2(database); }

  void open(const fs::path& file, int flags) {
    if (::sqlite3_open_v2(file.c_str(), &database, flags, nullptr) != SQLITE_OK)
      throw Error("bad-results", file.string() + " cannot be opened: " +
                                     (database ? ::sqlite3_errmsg(database) : "no memory"));
    ::sqlite3_busy_timeout(database, kBusy_ms);
  }
  void run(const std::string& text) const { Statement(database, text).step(); }
};

Store::Store(const fs::path& file, Open how) : work_(std::make_unique<Work>()) {
  if (how == Open::read) {
    if (!is_file(file))
      throw Error("no-results", "there are no results in " + file.string(), "run the sweep first");
    work_->open(file, SQLITE_OPEN_READWRITE);  // a reader takes back what a killed writer left half-written
    return;
  }
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error)
    throw Error("unwritable", file.parent_path().string() + " cannot be made: " + error.message(),
                "say --out FOLDER");
  work_->lock.emplace(file);
  work_->open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  work_->run("PRAGMA journal_mode=DELETE");  // no shared memory: it works on a network's file systems
  work_->run("PRAGMA synchronous=NORMAL");
  work_->run("CREATE TABLE IF NOT EXISTS results (" + schema() + ") WITHOUT ROWID");
  work_->run("CREATE TABLE IF NOT EXISTS inputs (name TEXT PRIMARY KEY, hash TEXT NOT NULL)");
}

Store::~Store() = default;

Inputs Store::inputs() const {
  Statement all(work_->database, "SELECT name, hash FROM inputs");
  Inputs out;
  while (all.step()) out[all.text(0)] = all.text(1);
  return out;
}

void Store::set_inputs(const Inputs& inputs) {
  work_->run("BEGIN");
  work_->run("DELETE FROM inputs");
  Statement add(work_->database, "INSERT INTO inputs VALUES (?, ?)");
  for (const auto& [name, hash] : inputs) {
    add.bind(1, name);
    add.bind(2, hash);
    add.step();
    add.reset();
  }
  work_->run("COMMIT");
}

void Store::clear() {
  work_->run("BEGIN");
  work_->run("DROP TABLE results");
  work_->run("CREATE TABLE results (" + schema() + ") WITHOUT ROWID");
  work_->run("DELETE FROM inputs");
  work_->run("COMMIT");
}

bool Store::has(const std::string& key) const {
  if (!work_->has) work_->has.emplace(work_->database, "SELECT 1 FROM results WHERE key = ?");
  work_->has->bind(1, key);
  const bool out = work_->has->step();
  work_->has->reset();  // it would keep the file locked
  return out;
}

std::optional<Row> Store::find(const std::string& key) const {
  if (!work_->find)
    work_->find.emplace(work_->database, "SELECT " + names_of_columns() + " FROM results WHERE key = ?");
  work_->find->bind(1, key);
  const auto out = work_->find->step() ? std::optional(row_at(*work_->find)) : std::nullopt;
  work_->find->reset();
  return out;
}

void Store::add(const Row& row) {
  std::string marks;
  for (std::size_t i = 0; i < columns().size(); ++i) marks += i == 0 ? "?" : ", ?";
  Statement add(work_->database,
                "INSERT OR IGNORE INTO results (" + names_of_columns() + ") VALUES (" + marks + ")");
  int index = 1;
  for (const Column& column : columns()) {
    if (column.text)
      add.bind(index++, row.*column.text);
    else
      add.bind(index++, row.*column.number);
  }
  add.step();
}

std::uint64_t Store::count() const {
  Statement count(work_->database, "SELECT count(*) FROM results");
  count.step();
  return static_cast<std::uint64_t>(count.number(0).value_or(0));
}

void Store::each(const std::function<void(const Row&)>& take) const {
  Statement all(work_->database, "SELECT " + names_of_columns() + " FROM results ORDER BY key");
  while (all.step()) take(row_at(all));
}

std::uint64_t Store::merge(const fs::path& other) {
  const Store from(other, Open::read);
  const Inputs own = inputs(), its = from.inputs();
  if (own.empty()) set_inputs(its);
  if (const auto changed = changes(own, its); !own.empty() && !changed.empty())
    throw Error("changed-inputs", other.string() + " is of other inputs: " + join(changed, ", "),
                "delete it, or put back what has changed");
  const std::uint64_t before = count();
  work_->run("BEGIN");
  from.each([this](const Row& row) { add(row); });
  work_->run("COMMIT");
  return count() - before;
}

}  // namespace polyarm::sweeps
