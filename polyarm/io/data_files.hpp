#pragma once
/// The data files of a running cell: loads them for programs, and writes changed values back.
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

/// Loads data sets into the store and writes through what programs, PLC and cameras set. Owned by the cell
/// thread, which never waits here: the worker accesses the disk.
class DataFiles {
 public:
  DataFiles(data::DataStore& store, StateFolder folder, Worker& worker, bool lock_step);

  /// Starts to load the data set `name`. Its values are in the store when poll_load() returns true.
  std::int64_t start_load(const std::string& name, const Location& where);
  /// True when done. Throws the error of the load.
  bool poll_load(std::int64_t handle);

  /// Loads the set and waits; only before the cell runs. Returns its ScriptFile, empty if it names none.
  /// Throws Error.
  std::filesystem::path load_now(const std::string& name, const Location& where);
  /// Names of the loaded sets, and the file that stores a set while the cell runs. Throws
  /// Error("unknown-set").
  std::vector<std::string> sets() const;
  std::filesystem::path file_of(const std::string& set) const;
  /// Sets the value of a name in the store and in the set's file; adds the name to the set if it is new.
  void put(const std::string& set, const std::string& name, const data::Value& value, const std::string& who);
  /// Removes the name from the set, and from the store unless another set has it.
  void remove(const std::string& set, const std::string& name);
  /// Puts the name into the group (empty: into none), in the store and in the set's file.
  void set_group(const std::string& set, const std::string& name, const std::string& group);
  /// Contents of the user's own file when the run last read it: at first load, plus the changes by requests
  /// since. Throws Error("unknown-set").
  data::DataSet& origin(const std::string& set);
  /// True if the set is bound to the user's own file.
  bool is_live(const std::string& set) const;
  /// True if a set is bound to the user's own file, which others may write.
  bool has_outside_writers() const { return folder_.has_live(); }

  /// Writes pending values of the store to the files (in lock-step only at intervals), and reads what others
  /// wrote.
  void exchange(Nanoseconds now);
  /// Writes everything to disk and waits for it.
  void flush();
  /// The first write error since the last call; empty if there was none.
  std::optional<Error> take_failure();
  /// Warnings of the mailboxes since the last call; each is reported once while the mailbox keeps trying.
  std::vector<Problem> take_warnings() { return std::exchange(warnings_, {}); }
  /// Returns why a pose that was written from outside must not be used, by the point's name; empty if it may
  /// be used.
  using PoseCheck = std::function<std::optional<std::string>(const std::string& name, const Pose& pose)>;
  void check_poses(PoseCheck check) { check_pose_ = std::move(check); }
  const StateFolder& folder() const { return folder_; }

 private:
  struct Load {
    data::LoadedFiles files, own;  ///< the run's copies, and the user's own files
    std::optional<Error> error;
    std::string name;
    Location where;
    std::uint64_t look = 0;  ///< the mailbox must have completed this look before the file is read
    bool posted = false;
    std::atomic<bool> ready{false};
  };
  /// One data file and how it is kept up to date.
  struct Bound {
    data::ImportFile file;                      ///< in lock-step: the contents to be written
    std::optional<data::DataSet> origin{};      ///< contents of the user's own file
    std::unique_ptr<signals::FileMailbox> box;  ///< null in lock-step, unless the set is live
  };
  void adopt(Load& load);
  void note_warnings(const data::ImportFile& own);
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
  std::set<std::string> noted_;  ///< warnings of data files, each reported once
  PoseCheck check_pose_;
  std::set<std::string> dirty_;
  std::map<std::int64_t, std::shared_ptr<Load>> loads_;
  std::mutex failure_mutex_;
  std::optional<Error> failure_;
  std::int64_t next_ = 1;
  Nanoseconds written_ = 0, looked_ = 0;
};

}  // namespace polyarm::cell
