#include "polyarm/cell/data_files.hpp"

#include <utility>

#include "polyarm/base/file.hpp"

namespace polyarm::cell {

namespace {
/// In lock-step, files are brought up to date at most this often, in cell time.
constexpr Nanoseconds kLockStepWrites = 1'000'000'000;

std::string set_name(const data::ImportFile& file) {
  return std::filesystem::path(file.file()).stem().string();
}
}  // namespace

DataFiles::DataFiles(data::DataStore& store, StateFolder folder, Worker& worker, bool lock_step)
    : store_(store), folder_(std::move(folder)), worker_(worker), lock_step_(lock_step) {}

std::int64_t DataFiles::start_load(const std::string& name, const Location& where) {
  write_through(written_);
  write_dirty();  // what is read back must have what was set before
  auto load = std::make_shared<Load>();
  load->name = name;
  const std::int64_t handle = next_++;
  loads_[handle] = load;
  worker_.post([this, load, name, where] {
    try {
      load->files = folder_.load(name, where);
    } catch (const Error& e) {
      load->error = e;
    }
    load->ready.store(true, std::memory_order_release);
  });
  return handle;
}

bool DataFiles::poll_load(std::int64_t handle) {
  const auto found = loads_.find(handle);
  if (found == loads_.end()) return true;
  const std::shared_ptr<Load> load = found->second;
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
  adopt(load);
  return load.files.script;
}

void DataFiles::adopt(Load& load) {
  const auto take = [&](const data::ImportFile& file) {
    const std::string set = set_name(file);
    files_[set] = std::make_shared<data::ImportFile>(file);
    store_.load(set, file.values(), "load " + load.name);
  };
  take(load.files.data);
  for (const data::ImportFile& points : load.files.points) take(points);
}

void DataFiles::write_through(Nanoseconds now) {
  for (const data::PendingWrite& write : store_.take_writes()) {
    const auto file = files_.find(write.set);
    if (file == files_.end()) continue;
    file->second->set(write.name, write.value);
    dirty_.insert(write.set);
  }
  if (!dirty_.empty() && (!lock_step_ || now - written_ >= kLockStepWrites)) {
    write_dirty();
    written_ = now;
  }
}

void DataFiles::write_dirty() {
  for (const std::string& set : dirty_) {
    const data::ImportFile& file = *files_.at(set);
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
  write_through(written_);
  write_dirty();
  worker_.drain();
}

}  // namespace polyarm::cell
