#include "polyarm/machine/fault_record.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/setup/cell_setup.hpp"
#include "polyarm/setup/floor.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/secrets.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

/// How long recording continues after a fault, ns.
constexpr Nanoseconds kAftermath = 200'000'000;
constexpr std::size_t kKeptRecords = 50;             // of each kind
constexpr std::uintmax_t kLargestKept = 10'000'000;  // size limit of one file of the cell, bytes
const std::vector<std::string> kHead = {"cycle", "state", "cause", "request"};
constexpr const char* kStates[] = {"running", "stopping", "held", "fault", "backing"};
constexpr const char* kRequests[] = {"none", "resume", "discard", "recover", "back"};

std::vector<std::string> first(const std::vector<std::string>& names, std::size_t count) {
  return {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// The number of a record's folder; empty for a folder with any other name.
std::optional<int> number_of(const fs::path& folder) {
  const std::string name = folder.filename().string();
  int number = 0;
  const auto [end, wrong] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (wrong != std::errc() || end != name.data() + name.size() || name.size() < 4) return std::nullopt;
  return number;
}

/// The next folder number after the highest; deletes the oldest records if there are too many.
fs::path next_folder(const fs::path& base) {
  fs::create_directories(base);
  std::map<int, fs::path> there;
  for (const auto& entry : fs::directory_iterator(base))
    if (const auto number = number_of(entry.path())) there[*number] = entry.path();
  std::error_code ignored;  // a folder that cannot be removed stays
  for (; there.size() >= kKeptRecords; there.erase(there.begin()))
    fs::remove_all(there.begin()->second, ignored);
  for (int n = there.empty() ? 1 : there.rbegin()->first + 1;; ++n) {
    std::string name = std::to_string(n);
    name.insert(0, name.size() < 4 ? 4 - name.size() : 0, '0');
    if (fs::create_directory(base / name)) return base / name;
  }
}

std::string number(double value) {
  return std::isnan(value) ? "nan" : std::isinf(value) ? (value < 0 ? "-inf" : "inf") : format_number(value);
}

void write_cycles(std::ostream& out, const FaultRecord& record, const control::BlackBox& box) {
  out << join(kHead, ",");
  for (const std::string& name : record.states) out << ',' << name;
  for (const std::string& name : record.commands) out << ",command:" << name;
  out << '\n';
  for (std::size_t i = 0; i < box.rows(); ++i) {
    const control::BlackBox::Row row = box.row(i);
    std::string text = std::to_string(row.cycle) + ',' + kStates[static_cast<std::size_t>(row.state)] + ',' +
                       std::to_string(static_cast<int>(row.cause)) + ',' +
                       kRequests[static_cast<std::size_t>(row.request)];
    for (const auto& values : {row.states, row.commands})
      for (const double value : values) text += ',' + number(value);
    out << text << '\n';
  }
}

/// Copies a file without secrets, and not through links that lead outside the cell.
void keep_copy(const fs::path& file, const fs::path& to) {
  Problems left_out;
  collect(left_out, [&] {
    const std::string text = read_file(file, kLargestKept);
    if (!is_secret(file, text)) write_file_atomically(to, without_secrets(text), 0600);
  });
}

}  // namespace

FaultRecord begin_record(const CellSetup& setup, control::ControlLoop& loop, Problem problem,
                         const std::string& stop) {
  FaultRecord out;
  out.cell_folder = setup.file.folder;
  out.problem = std::move(problem);
  out.stop = stop;
  out.period_s = seconds(loop.options().period);
  out.states = first(loop.table().state_names(), loop.table().built_states());
  out.commands = first(loop.table().command_names(), loop.table().built_commands());
  for (const auto& robot : setup.robots)
    out.files[robot->entry.name + ".urdf"] = description::write_urdf(robot->model);
  return out;
}

fs::path write_record(const FaultRecord& record, const char* kind) noexcept {
  try {
    const fs::path state = record.cell_folder / ".state";
    reach().check(state / kind, Reach::Use::write);
    const fs::path folder = next_folder(state / kind);
    fs::permissions(folder, fs::perms::owner_all);
    write_file_atomically(state / ".gitignore", "*\n");
    for (const auto& entry : fs::directory_iterator(record.cell_folder))
      if (entry.is_regular_file() && entry.file_size() < kLargestKept)
        keep_copy(entry.path(), folder / entry.path().filename());
    for (const auto& [name, text] : record.files)
      write_file_atomically(folder / name, without_secrets(text), 0600);
    write_file_atomically(folder / "fault.txt", "polyarm: fault/1\nperiod: " + number(record.period_s) +
                                                    "\n" + record.problem.text() + "\n" +
                                                    (record.stop.empty() ? "" : record.stop + "\n"));
    std::ofstream cycles(folder / "cycles.csv");
    write_cycles(cycles, record, record.box ? record.box->box : *record.stopped);
    cycles.close();
    return cycles ? folder : fs::path{};
  } catch (const std::exception&) {
    return {};
  }
}

void FaultRecorder::begin(FaultRecord record, Nanoseconds now) {
  record_ = std::make_unique<FaultRecord>(std::move(record));
  due_ = now + kAftermath;
}

std::optional<std::string> FaultRecorder::tick(Nanoseconds now, control::ControlLoop& loop, Worker& worker) {
  if (record_ && now >= due_) {
    if (!record_->box) {
      Problems busy;  // tried again in the next tick
      collect(busy, [&] { record_->box = loop.take_black_box(); });
    } else if (record_->box->done()) {
      auto folder = std::make_shared<std::promise<fs::path>>();
      written_ = folder->get_future();
      worker.post([folder, record = std::shared_ptr<FaultRecord>(std::move(record_))] {
        folder->set_value(write_record(*record, "faults"));
      });
    }
  }
  if (!written_.valid() || written_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return std::nullopt;
  const fs::path folder = written_.get();
  return folder.empty() ? "the cycles before the fault could not be written"
                        : "the cycles before the fault: polyarm replay " + folder.string();
}

RecordedCycles read_cycles(const fs::path& csv) {
  RecordedCycles out;
  const std::string text = read_file(csv);
  int line = 0;
  const auto refuse = [&](const std::string& what) {
    throw Error(
        Problem{"no-record", {csv.string(), line}, what, "name the folder of a fault: .state/faults/0001"});
  };
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const std::vector<std::string> fields =
        split_fields(std::string_view(text).substr(from, end - from), ',');
    from = end + 1;
    if (++line == 1) {
      if (fields.size() < kHead.size() || !std::equal(kHead.begin(), kHead.end(), fields.begin()))
        refuse("the first line does not begin with " + join(kHead, ","));
      for (std::size_t k = kHead.size(); k < fields.size(); ++k)
        if (fields[k].starts_with("command:"))
          out.commands.push_back(fields[k].substr(8));
        else
          out.states.push_back(fields[k]);
      continue;
    }
    if (fields.size() != kHead.size() + out.states.size() + out.commands.size())
      refuse("the line has " + std::to_string(fields.size()) + " columns, the first one " +
             std::to_string(kHead.size() + out.states.size() + out.commands.size()));
    RecordedCycles::Row row;
    const auto cycle = parse_number(fields[0]);
    if (!cycle || !(*cycle >= 0 && *cycle <= 1e15)) refuse("'" + fields[0] + "' is not a cycle");
    row.cycle = static_cast<std::uint64_t>(*cycle);
    row.state = fields[1];
    row.cause = fields[2];
    row.request = fields[3];
    for (std::size_t k = kHead.size(); k < fields.size(); ++k) {
      const std::string& field = fields[k];
      double value = std::numeric_limits<double>::quiet_NaN();
      if (field == "inf" || field == "-inf")
        value = field == "inf" ? std::numeric_limits<double>::infinity()
                               : -std::numeric_limits<double>::infinity();
      else if (const auto read = parse_number(field))
        value = *read;
      else if (field != "nan")
        refuse("'" + field + "' is not a number");
      (k < kHead.size() + out.states.size() ? row.states : row.commands).push_back(value);
    }
    out.rows.push_back(std::move(row));
  }
  if (out.rows.empty()) refuse("no cycles were recorded");
  return out;
}

namespace {

/// The robots of a record in the state of its first cycle.
CellRobots recorded_robots(const fs::path& folder, const RecordedCycles& recorded,
                           const std::string& hardware) {
  CellRobots out;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    const std::string prefix = name + "/";
    const bool is_robot = entry.path().extension() == ".urdf" &&
                          std::any_of(recorded.states.begin(), recorded.states.end(),
                                      [&](const auto& s) { return s.starts_with(prefix); });
    if (!is_robot) continue;
    auto robot = std::make_unique<CellRobot>();
    Problems warnings;
    robot->entry.name = name;
    robot->entry.hardware = robot->driver = hardware;
    robot->model = description::read_urdf(read_file(entry.path()), entry.path().string(), warnings);
    for (const description::HardwareInfo& info : robot->model.hardware)
      robot->blocks.push_back({&info, hardware, {}});
    for (const std::string& joint : robot->model.joint_names()) {
      const auto at = std::find(recorded.states.begin(), recorded.states.end(), prefix + joint + "/position");
      double start = 0;
      for (std::size_t r = 0; at != recorded.states.end() && r < recorded.rows.size(); ++r)
        if (const double q = recorded.rows[r].states[static_cast<std::size_t>(at - recorded.states.begin())];
            std::isfinite(q)) {
          start = q;
          break;
        }
      robot->start.push_back(start);
    }
    out.push_back(std::move(robot));
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return a->entry.name < b->entry.name; });
  return out;
}

}  // namespace

Replay replay_record(const fs::path& folder, const std::string& hardware) {
  Replay out;
  out.driver = hardware;
  std::error_code error;
  if (!fs::is_regular_file(folder / "cycles.csv", error))
    throw Error(Problem{"no-record",
                        {folder.string()},
                        fs::is_directory(folder, error) ? "this folder has no record of a fault"
                        : fs::exists(folder, error)     ? "this is a file, not the folder of a fault"
                                                        : "there is no such folder",
                        "name the folder of a fault: .state/faults/0001"});
  out.recorded = read_cycles(folder / "cycles.csv");
  const std::string fault = read_file(folder / "fault.txt");
  const std::vector<std::string> lines = split_fields(fault, '\n');
  if (lines.size() < 3 || lines[0] != "polyarm: fault/1")
    throw Error(Problem{"no-record",
                        {(folder / "fault.txt").string(), 1},
                        "this is not a record of a fault",
                        "name the folder of a fault: .state/faults/0001"});
  out.problem = lines[2];
  const double period = parse_number(lines[1].substr(lines[1].find(' ') + 1)).value_or(1e-3);
  if (!(period >= 1e-5 && period <= 10))
    throw Error(Problem{"no-record",
                        {(folder / "fault.txt").string(), 2},
                        "'" + shortened(lines[1]) + "' is not a period of a control loop",
                        "it has the seconds of one cycle, as in 'period: 0.001'"});

  realtime::Jobs jobs;
  hardware::InterfaceTable table;
  hardware::Hardware components(table, jobs);
  const CellRobots robots = recorded_robots(folder, out.recorded, hardware);
  std::vector<std::string> notes;
  const description::Scene scene = scene_without_file(robots, notes);
  Problems problems;
  add_components(components, robots, scene, nanoseconds(period), true, ros_files::ManagerParameters{},
                 problems);
  problems.throw_if_errors();
  components.configure_and_activate();

  struct Column {
    std::size_t recorded, here;
  };
  std::vector<Column> commands, positions;
  for (std::size_t k = 0; k < out.recorded.commands.size(); ++k)
    if (const auto here = table.find_command(out.recorded.commands[k])) commands.push_back({k, *here});
  for (std::size_t k = 0; k < out.recorded.states.size(); ++k)
    if (const auto here = table.find_state(out.recorded.states[k]);
        here && out.recorded.states[k].ends_with("/position")) {
      positions.push_back({k, *here});
      out.joints.push_back({out.recorded.states[k].substr(0, out.recorded.states[k].rfind('/')), 0, 0});
    }
  hardware::Cycle cycle{0, nanoseconds(period), 0};
  hardware::FaultEvents ignored;
  for (const RecordedCycles::Row& row : out.recorded.rows) {
    components.exchange().read(cycle, ignored);
    for (std::size_t j = 0; j < positions.size(); ++j) {
      const double off = std::abs(table.states()[positions[j].here] - row.states[positions[j].recorded]);
      if (off > out.joints[j].worst) out.joints[j] = {out.joints[j].name, off, row.cycle};
    }
    for (const Column& c : commands) table.commands()[c.here] = row.commands[c.recorded];
    components.exchange().write(cycle, ignored);
    ignored.clear();
    cycle.time += cycle.period;
    ++cycle.index;
  }
  return out;
}

}  // namespace polyarm::cell
