#include "polyarm/io/data_files.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/data/set_edit.hpp"

namespace polyarm::cell {

namespace {
/// In lock-step, files are written at most once per this cell time, ns.
constexpr Nanoseconds kLockStepWrites = 1'000'000'000;
/// In lock-step, files of live sets are read at this interval of cell time, ns.
constexpr Nanoseconds kLockStepLooks = 20'000'000;

std::string stem_of(const data::ImportFile& file) {
  return std::filesystem::path(file.file()).stem().string();
}

std::string name_of(const data::ImportFile& file) {
  return std::filesystem::path(file.file()).filename().string();
}
/// Name of the data set of `file`: the file name without extension; with extension if another file has the
/// same name, such as job.data and job.points.
template <typename Files>
std::string set_for(const data::ImportFile& file, const Files& files) {
  const auto same = files.find(stem_of(file));
  const bool taken = same != files.end() && same->second.file.file() != file.file();
  return taken ? name_of(file) : stem_of(file);
}

/// Finds the file by the name that a program uses, with or without extension.
template <typename Files>
auto bound_as(const std::string& name, const Files& files) {
  const auto found = files.find(name);
  if (found != files.end()) return found;
  return std::find_if(files.begin(), files.end(),
                      [&](const auto& each) { return name_of(each.second.file) == name; });
}
}  // namespace

DataFiles::DataFiles(data::DataStore& store, StateFolder folder, Worker& worker, bool lock_step)
    : store_(store), folder_(std::move(folder)), worker_(worker), lock_step_(lock_step) {}

std::int64_t DataFiles::start_load(const std::string& name, const Location& where) {
  exchange(written_);
  write_dirty();  // the file must contain earlier writes before it is read
  auto load = std::make_shared<Load>();
  load->name = name;
  load->where = where;
  if (const auto bound = bound_as(name, files_); bound != files_.end() && bound->second.box)
    load->look = bound->second.box->check_from_now();
  const std::int64_t handle = next_++;
  loads_[handle] = load;
  if (caught_up(*load)) post(load);
  return handle;
}

bool DataFiles::caught_up(const Load& load) const {
  const auto bound = bound_as(load.name, files_);
  if (bound == files_.end() || !bound->second.box) return true;
  const signals::FileMailbox& box = *bound->second.box;
  return box.written() == box.posted() && box.looks() >= load.look;
}

void DataFiles::post(const std::shared_ptr<Load>& load) {
  load->posted = true;
  worker_.post([this, load] {
    try {
      load->files = folder_.load(load->name, load->where);
      load->own = folder_.original(load->name, load->where);
    } catch (const Error& e) {
      load->error = e;
    }
    load->ready.store(true, std::memory_order_release);
  });
}

bool DataFiles::poll_load(std::int64_t handle) {
  const auto found = loads_.find(handle);
  if (found == loads_.end()) return true;
  const std::shared_ptr<Load> load = found->second;
  if (!load->posted && caught_up(*load)) post(load);
  if (!load->ready.load(std::memory_order_acquire)) return false;
  loads_.erase(found);
  if (load->error) throw *load->error;
  adopt(*load);
  return true;
}

std::filesystem::path DataFiles::load_now(const std::string& name, const Location& where) {
  Load load;
  load.name = name;
  load.files = folder_.load(name, where);
  load.own = folder_.original(name, where);
  adopt(load);
  return load.files.script;
}

void DataFiles::bind(const data::ImportFile& file, const data::DataSet& own, const std::string& who) {
  const std::string set = set_for(file, files_);
  Bound& bound = files_[set];
  bound.file = file;
  if (!bound.origin) bound.origin = own;
  const bool live = folder_.is_live(stem_of(file));
  if ((live || !lock_step_) && (!bound.box || bound.box->path() != file.file())) {
    signals::MailboxOptions options;
    options.thread = !lock_step_;
    bound.box = std::make_unique<signals::FileMailbox>(file, options);
  }
  store_.load(set, file.values(), who);
}

void DataFiles::note_warnings(const data::ImportFile& own) {
  constexpr std::size_t kMost = 1000;  // a file that another program writes may bring others each time
  for (const Problem& each : own.warnings())
    if (noted_.size() < kMost && noted_.insert(each.text()).second) warnings_.push_back(each);
}

void DataFiles::adopt(Load& load) {
  note_warnings(load.own.data);
  for (const data::ImportFile& points : load.own.points) note_warnings(points);
  bind(load.files.data, load.own.data.values(), "load " + load.name);
  for (const data::ImportFile& points : load.files.points) {
    const auto same = [&](const data::ImportFile& each) { return name_of(each) == name_of(points); };
    const auto own = std::find_if(load.own.points.begin(), load.own.points.end(), same);
    bind(points, own == load.own.points.end() ? points.values() : own->values(), "load " + load.name);
  }
}

std::vector<std::string> DataFiles::sets() const {
  std::vector<std::string> out;
  for (const auto& [set, bound] : files_) out.push_back(set);
  return out;
}

std::filesystem::path DataFiles::file_of(const std::string& set) const {
  const auto found = files_.find(set);
  if (found == files_.end()) throw Error("unknown-set", "there is no data set '" + set + "'");
  return found->second.file.file();
}

data::DataSet& DataFiles::origin(const std::string& set) {
  const auto found = files_.find(set);
  if (found == files_.end()) throw Error("unknown-set", "there is no data set '" + set + "'");
  return *found->second.origin;
}

bool DataFiles::is_live(const std::string& set) const {
  const auto found = files_.find(set);
  return found != files_.end() && folder_.is_live(stem_of(found->second.file));
}

void DataFiles::put(const std::string& set, const std::string& name, const data::Value& value,
                    const std::string& who) {
  const data::Value* known = store_.find(name);
  if (!known || store_.set_of(name).empty()) {
    // Adds the name to the set; the value below is then pending for the set's file.
    store_.take_outside(set, {{name, data::Value(false)}}, who);
  }
  store_.set(name, value, who);
}

void DataFiles::remove(const std::string& set, const std::string& name) {
  const auto found = files_.find(set);
  if (found == files_.end()) return;
  exchange(written_);  // keep writes that are still pending
  data::DataSet left;
  for (const std::string& each : store_.names())
    if (each != name && store_.set_of(each) == set) {
      left.set(each, *store_.find(each));
      left.set_group(each, store_.group_of(each));
    }
  store_.load(set, left, "a person");
  Bound& bound = found->second;
  if (bound.file.values().find(name)) bound.file = data::without(bound.file, name);
  if (folder_.is_live(stem_of(bound.file))) return;  // the user's own file, changed already
  if (lock_step_) {
    dirty_.insert(set);
    return;
  }
  worker_.post([path = std::filesystem::path(bound.file.file()), name] {
    try {
      const data::ImportFile copy = data::ImportFile::load(path.string());
      if (copy.values().find(name)) write_file_atomically(path, data::without(copy, name).text());
    } catch (const Error&) {  // the next run makes a new copy
    }
  });
}

void DataFiles::set_group(const std::string& set, const std::string& name, const std::string& group) {
  const auto found = files_.find(set);
  if (found == files_.end()) return;
  store_.set_group(name, group);
  exchange(written_);  // so a new name is in the file first
  Bound& bound = found->second;
  if (bound.file.values().find(name)) bound.file.set_group(name, group);
  if (folder_.is_live(set)) return;  // the user's own file, changed already
  if (bound.box)
    bound.box->post_group(name, group);
  else
    dirty_.insert(set);
}

/// A pose from outside is accepted completely or not at all.
bool DataFiles::refuses(const std::string& file, const std::string& name, const data::Value& value) {
  const data::Point* point = value.as_point();
  const auto why = point && check_pose_ ? check_pose_(name, point->pose) : std::nullopt;
  if (why)
    warnings_.push_back({"refused-value",
                         {file},
                         "the pose that was written into '" + name + "' is not taken: " + *why,
                         "the point stays as it was",
                         Severity::warning});
  return why.has_value();
}

void DataFiles::take_from(const std::string& set, signals::FileMailbox& box) {
  for (signals::MailboxEvent& event : box.take_events()) {
    std::erase_if(event.values,
                  [&](const auto& value) { return refuses(box.path(), value.first, value.second); });
    if (event.kind == signals::MailboxEvent::Kind::changed) store_.take_outside(set, event.values, "outside");
    for (const auto& [name, group] : event.groups) store_.set_group(name, group);
    for (Problem& problem : event.problems) {
      problem.severity = Severity::warning;
      warnings_.push_back(std::move(problem));
    }
  }
}

void DataFiles::exchange(Nanoseconds now) {
  std::map<std::string, std::vector<std::pair<std::string, data::Value>>> posts;  // grouped by set
  for (data::PendingWrite& write : store_.take_writes()) {
    const auto bound = files_.find(write.set);
    if (bound == files_.end()) continue;
    if (bound->second.box) {
      posts[write.set].emplace_back(std::move(write.name), std::move(write.value));
      continue;
    }
    bound->second.file.set(write.name, write.value);
    dirty_.insert(write.set);
  }
  for (const auto& [set, values] : posts) files_.at(set).box->post(values);
  const bool look = !lock_step_ || now - looked_ >= kLockStepLooks;
  if (look) looked_ = now;
  for (auto& [set, bound] : files_) {
    if (!bound.box || !look) continue;
    if (lock_step_) bound.box->step();
    take_from(set, *bound.box);
  }
  if (!dirty_.empty() && now - written_ >= kLockStepWrites) {
    write_dirty();
    written_ = now;
  }
}

void DataFiles::write_dirty() {
  for (const std::string& set : dirty_) {
    const data::ImportFile& file = files_.at(set).file;
    worker_.post([this, path = std::filesystem::path(file.file()), text = file.text()] {
      try {
        write_file_atomically(path, text);
      } catch (const Error& e) {
        const std::lock_guard lock(failure_mutex_);
        if (!failure_) failure_ = e;
      }
    });
  }
  dirty_.clear();
}

std::optional<Error> DataFiles::take_failure() {
  const std::lock_guard lock(failure_mutex_);
  return std::exchange(failure_, std::nullopt);
}

void DataFiles::flush() {
  exchange(written_);
  write_dirty();
  worker_.drain();
  for (auto& [set, bound] : files_) bound.box.reset();  // writes the posted values, then ends
}

}  // namespace polyarm::cell
