#pragma once
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/io/state_folder.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/signals/file_mailbox.hpp"

namespace polyarm::cell {

/// The data files of a running cell: loads them for programs and writes through what programs, PLC and
/// cameras set. Owned by the cell thread, which never waits here: disk is touched by the worker.
class DataFiles {
 public:
  DataFiles(data::DataStore& store, StateFolder folder, Worker& worker, bool lock_step);

  /// Starts to load the data set `name`; its values are in the store when poll says so.
  std::int64_t start_load(const std::string& name, const Location& where);
  /// True when done. Throws what went wrong.
  bool poll_load(std::int64_t handle);

  /// Loads it and waits: before the cell runs. Returns its ScriptFile, empty if it names none. Throws Error.
  std::filesystem::path load_now(const std::string& name, const Location& where);
  /// The sets that are loaded, and the file that each is kept in while the cell runs. Throws
  /// Error("unknown-set").
  std::vector<std::string> sets() const;
  std::filesystem::path file_of(const std::string& set) const;
  /// A name of the set gets the value, or is new in it; in the store and in the set's file.
  void put(const std::string& set, const std::string& name, const data::Value& value, const std::string& who);
  /// The name goes from the set, and from the store where no other set has it.
  void remove(const std::string& set, const std::string& name);
  /// The name is in the group (an empty text: in none) in the store and in the file that the set is kept in.
  void set_group(const std::string& set, const std::string& name, const std::string& group);
  /// The set as the user's own file had it when the run last took it from there: at its first sight, and what
  /// requests have changed in it since. Throws Error("unknown-set").
  data::DataSet& origin(const std::string& set);
  /// Is the set bound to the user's own file?
  bool is_live(const std::string& set) const;
  /// True when a data set is bound to its own file, which somebody outside may write.
  bool has_outside_writers() const { return folder_.has_live(); }

  /// Puts pending writes of the store into the files (now and then in lock-step), and takes what others
  /// wrote.
  void exchange(Nanoseconds now);
  /// Everything to disk, and waits for it.
  void flush();
  /// The first file that could not be written since the last call; empty if all is well.
  std::optional<Error> take_failure();
  /// What the mailboxes complain of since the last call; each says a thing once and goes on trying.
  std::vector<Problem> take_warnings() { return std::exchange(warnings_, {}); }
  /// Why a pose that somebody outside wrote may not be used, by the point's name; nothing where it may.
  using PoseCheck = std::function<std::optional<std::string>(const std::string& name, const Pose& pose)>;
  void check_poses(PoseCheck check) { check_pose_ = std::move(check); }
  const StateFolder& folder() const { return folder_; }

 private:
  struct Load {
    data::LoadedFiles files, own;  ///< the copies, and the user's own
    std::optional<Error> error;
    std::string name;
    Location where;
    std::uint64_t look = 0;  ///< of the set's mailbox, that must be over before the file is read
    bool posted = false;
    std::atomic<bool> ready{false};
  };
  /// One data file and how it is kept up to date.
  struct Bound {
    data::ImportFile file;                      ///< lock-step: as it is to be written
    std::optional<data::DataSet> origin{};      ///< as the user's own file has it
    std::unique_ptr<signals::FileMailbox> box;  ///< else
  };
  void adopt(Load& load);
  void bind(const data::ImportFile& file, const data::DataSet& own, const std::string& who);
  void post(const std::shared_ptr<Load>& load);
  bool caught_up(const Load& load) const;
  bool refuses(const std::string& file, const std::string& name, const data::Value& value);
  void take_from(const std::string& set, signals::FileMailbox& box);
  void write_dirty();

  data::DataStore& store_;
  StateFolder folder_;
  Worker& worker_;
  bool lock_step_;
  std::map<std::string, Bound> files_;  ///< by set
  std::vector<Problem> warnings_;
  PoseCheck check_pose_;
  std::set<std::string> dirty_;
  std::map<std::int64_t, std::shared_ptr<Load>> loads_;
  std::mutex failure_mutex_;
  std::optional<Error> failure_;
  std::int64_t next_ = 1;
  Nanoseconds written_ = 0, looked_ = 0;
};

}  // namespace polyarm::cell
