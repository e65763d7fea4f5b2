#include "drivers/servo_bus/commissioning.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/serial/ports.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::servo_bus {

namespace {
constexpr int kAttempts = 3, kTries = 5;
constexpr int kLeastRange = 60;  // steps, 5°: a smaller range means that the joint was not moved
/// Looks at the joints between two saves of what was measured, and between two attempts to open a port that
/// is gone.
constexpr int kLooksToSave = 20, kLooksToReopen = 50;

bool yes(const std::string& answer) {
  return equal_ignoring_case(trim(answer), "yes") || equal_ignoring_case(trim(answer), "y");
}

std::string line(const FoundServo& servo, const Family& family) {
  const Model* model = find_model(family, servo.model);
  std::string name = model ? model->name : "unknown model";
  return "id " + std::to_string(servo.id) + " at " + std::to_string(servo.baud) + " bit/s: " + name + " (" +
         std::to_string(servo.model) + "), firmware " + std::to_string(servo.firmware) + ", " +
         format_number(std::round(servo.voltage * 10) / 10) + " V, " + format_number(servo.temperature) +
         " °C";
}
}  // namespace

Commissioning::Commissioning(const Family& family, std::function<std::unique_ptr<Protocol>()> protocol,
                             CommissioningOptions options, Dialogue& dialogue)
    : family_(family), protocol_(std::move(protocol)), options_(std::move(options)), dialogue_(dialogue) {
  if (options_.highest_id <= 0 || options_.highest_id > family.highest_id)
    options_.highest_id = family.highest_id;
  read_calibration();
}

void Commissioning::open(const std::string& port, int baud) {
  bus_.reset();
  auto bus = std::make_unique<ServoBus>(family_, protocol_());
  serial::PortOptions options;
  options.path = port;
  options.baud = baud;
  options.holder = "polyarm setup";
  bus->open(options, options_.answer_timeout);
  bus_ = std::move(bus);
  baud_ = baud;
}

std::int32_t Commissioning::get(int id, const Register& reg) {
  std::int32_t value = 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt)
    if (bus_->read(static_cast<std::uint8_t>(id), reg, value) == Outcome::ok) return value;
  throw Error("no-servo", "servo " + std::to_string(id) + " on " + bus_->port() + " has stopped answering",
              "check its cable and power, and run this again: it continues where it was");
}

std::optional<FoundServo> Commissioning::look_at(int id, int baud) {
  if (bus_->ping(static_cast<std::uint8_t>(id)) != Outcome::ok) return std::nullopt;
  FoundServo servo{id, baud, get(id, family_.model), get(id, family_.firmware)};
  servo.voltage = get(id, family_.present_voltage) * family_.voltage_unit;
  servo.temperature = get(id, family_.present_temperature);
  return servo;
}

std::vector<FoundServo> Commissioning::scan(int baud) {
  if (baud != baud_) {
    bus_->set_baud(baud);
    baud_ = baud;
  }
  std::vector<FoundServo> out;
  for (int id = 0; id <= options_.highest_id; ++id)
    if (const auto servo = look_at(id, baud)) out.push_back(*servo);
  return out;
}

std::vector<FoundServo> Commissioning::find() {
  std::vector<int> bauds{options_.baud > 0 ? options_.baud : family_.default_baud};
  if (options_.baud <= 0)
    for (const int baud : family_.bauds)
      if (baud != bauds.front()) bauds.push_back(baud);
  const std::vector<std::string> ports =
      options_.port.empty() ? serial::list_ports() : std::vector<std::string>{options_.port};
  if (ports.empty())
    throw Error("no-such-port", "this machine has no serial port with a device",
                "plug the adapter in and give it power, or name it with --port");
  Problems problems;
  for (const std::string& port : ports) {
    try {
      open(port, bauds.front());
      for (const int baud : bauds) {
        dialogue_.say("looking on " + port + " at " + std::to_string(baud) + " bit/s");
        std::vector<FoundServo> found;
        try {
          found = scan(baud);
        } catch (const Error& e) {
          if (e.problems().front().code != "baud-not-supported") throw;
        }
        if (found.empty()) continue;
        for (const FoundServo& servo : found) dialogue_.say("  " + line(servo, family_));
        options_.port = port;
        return found;
      }
    } catch (const Error& e) {
      problems.add(e);
    }
  }
  problems.error(
      "no-servo", {}, std::string("no ") + family_.name + " servo answers on " + join(ports, ", "),
      "check that the servos have power of their own, the three wires, and the direction switch of the "
      "adapter");
  throw Error(problems.list());
}

void Commissioning::set_lasting(int id, const Register& reg, std::int32_t value) {
  const auto own = static_cast<std::uint8_t>(id);
  bool done = !family_.lock || bus_->write_checked(own, family_.lock, 0) == Outcome::ok;
  done = bus_->write_checked(own, reg, value) == Outcome::ok && done;
  if (family_.lock) done = bus_->write_checked(own, family_.lock, 1) == Outcome::ok && done;
  if (!done)
    throw Error("write-refused",
                "servo " + std::to_string(id) + " did not take " + std::to_string(value) + " at address " +
                    std::to_string(reg.address),
                "check its cable and power, and run this again");
}

int Commissioning::id_of(const std::string& joint) const {
  const auto at = std::find(options_.joints.begin(), options_.joints.end(), joint);
  return static_cast<int>(at - options_.joints.begin()) + 1;
}

void Commissioning::give_id(const FoundServo& servo, int id) {
  if (servo.id == id) return;
  const auto from = static_cast<std::uint8_t>(servo.id), to = static_cast<std::uint8_t>(id);
  if (get(servo.id, family_.torque) != 0) take_torque_off({servo.id}, "its id is to change");
  if (family_.lock && bus_->write_checked(from, family_.lock, 0) != Outcome::ok)
    throw Error("write-refused", "servo " + std::to_string(servo.id) + " does not open its lock",
                "run this again");
  bus_->write(from, family_.id, id);  // the answer may come from the old or the new id
  for (int attempt = 0; attempt < kAttempts; ++attempt)
    if (bus_->ping(to) == Outcome::ok) {
      if (family_.lock) bus_->write_checked(to, family_.lock, 1);
      return;
    }
  throw Error("write-refused", "servo " + std::to_string(servo.id) + " did not become " + std::to_string(id),
              "switch its power off and on, and run this again");
}

void Commissioning::assign_ids() {
  if (!bus_) open(options_.port, options_.baud > 0 ? options_.baud : family_.default_baud);
  bool asked = false;
  for (const std::string& joint : options_.joints) {
    const int id = id_of(joint);
    if (calibration_[joint].id == id) continue;
    for (int attempt = 0;; ++attempt) {
      if (attempt == kTries)
        throw Error("no-servo", "no single servo was found for " + joint,
                    "run this again: it continues with " + joint);
      asked = true;
      dialogue_.ask("Connect the servo of " + joint + " alone to the adapter, then press Enter");
      const std::vector<FoundServo> found = find();
      if (found.size() != 1) {
        dialogue_.say(std::to_string(found.size()) + " servos answer: disconnect all but that of " + joint);
        continue;
      }
      give_id(found.front(), id);
      if (found.front().baud != family_.default_baud)
        dialogue_.say("  it speaks at " + std::to_string(found.front().baud) +
                      " bit/s; set this as baud: in the cell");
      calibration_[joint].id = id;
      calibration_[joint].model = found.front().model;
      write_calibration();
      dialogue_.say(joint + " is servo " + std::to_string(id) + " now; mark it");
      break;
    }
  }
  if (asked) dialogue_.ask("Connect all servos again, then press Enter");
}

bool Commissioning::check() {
  if (!bus_) find();
  bool good = true;
  const auto complain = [&](const std::string& text) {
    good = false;
    dialogue_.say("  " + text);
  };
  std::optional<FoundServo> first;
  for (const std::string& joint : options_.joints) {
    const int id = id_of(joint);
    std::optional<FoundServo> servo;
    for (int attempt = 0; attempt < kAttempts && !servo; ++attempt) servo = look_at(id, baud_);
    if (!servo) {
      complain(joint + ": servo " + std::to_string(id) + " does not answer");
      continue;
    }
    dialogue_.say(joint + ": " + line(*servo, family_));
    if (!first) first = servo;
    if (!find_model(family_, servo->model)) complain("this model is not known here");
    if (servo->firmware != first->firmware && servo->model == first->model)
      complain("its firmware differs from that of the first: update it with the maker's tool");
    const double low = get(id, family_.min_voltage) * family_.voltage_unit,
                 high = get(id, family_.max_voltage) * family_.voltage_unit;
    if (servo->voltage < low || servo->voltage > high)
      complain("its voltage is outside " + format_number(low) + " to " + format_number(high) + " V");
    if (const std::int32_t status = get(id, family_.status))
      complain("it reports " + status_names(family_, static_cast<unsigned>(status)));
    calibration_[joint].id = id;
    calibration_[joint].model = servo->model;
  }
  return good;
}

std::filesystem::path Commissioning::back_up() {
  std::string text = std::string("polyarm: servo_backup/1\nfamily: ") + family_.name + "\nservos:\n";
  for (const std::string& joint : options_.joints) {
    const int id = id_of(joint);
    text += "  " + std::to_string(id) + ":  # " + joint +
            "\n    model: " + std::to_string(get(id, family_.model)) + "\n    registers:\n";
    for (const NamedRegister& named : family_.lasting)
      text += std::string("      ") + named.name + ": " + std::to_string(get(id, named.reg)) + "\n";
  }
  std::filesystem::path path = options_.backup;
  std::error_code ignored;
  for (int n = 2; std::filesystem::exists(path, ignored); ++n)
    path = options_.backup.parent_path() /
           (options_.backup.stem().string() + "-" + std::to_string(n) + options_.backup.extension().string());
  write_file_atomically(path, text);
  dialogue_.say("registers kept in " + path.string() + "; `polyarm setup " + family_.name + " --restore " +
                path.string() + "` writes them back");
  return path;
}

std::vector<int> Commissioning::ids() const {
  std::vector<int> out;
  for (const std::string& joint : options_.joints) out.push_back(id_of(joint));
  return out;
}

void Commissioning::take_torque_off(const std::vector<int>& ids, const std::string& why) {
  if (!yes(dialogue_.ask("Torque goes off (" + why + ") and the arm will sink. Hold it, then type yes")))
    throw Error("not-agreed", "torque stays as it is: that was not yes",
                "run this again when the arm is supported");
  for (const int id : ids) {
    const auto own = static_cast<std::uint8_t>(id);
    if (bus_->write_checked(own, family_.torque, 0) != Outcome::ok)
      throw Error("write-refused", "servo " + std::to_string(id) + " does not switch its torque off",
                  "switch its power off");
  }
}

/// Tracks each joint through the end of the count, where 0 follows 4095. A joint that is known from an
/// earlier run, or from before the adapter was gone, continues at the turn nearest to its range.
void Commissioning::follow(Ranges& ranges) {
  if (reopen_if_gone()) return;
  const int turn = family_.steps_per_turn;
  for (auto& [joint, range] : ranges) {
    std::int32_t at = 0;
    const Outcome outcome = bus_->read(static_cast<std::uint8_t>(id_of(joint)), family_.present_position, at);
    if (outcome == Outcome::gone) return lose_adapter(ranges);
    if (outcome != Outcome::ok) continue;
    if (!std::exchange(range.known, true)) {
      range.last = at;
      if (!range.moved) range.min = range.max = at;
      const double middle = (range.min + range.max) / 2.0;
      range.turns = turn * static_cast<int>(std::lround((middle - at) / turn));
    }
    if (at - range.last > turn / 2) range.turns -= turn;
    if (at - range.last < -turn / 2) range.turns += turn;
    range.last = at;
    range.min = std::min(range.min, range.now());
    range.max = std::max(range.max, range.now());
  }
  if (++looks_ % kLooksToSave == 0) save(ranges);
}

/// Joints may be turned far until the adapter is back: they then continue at the turn nearest to their range.
void Commissioning::lose_adapter(Ranges& ranges) {
  bus_.reset();
  looks_ = 0;
  for (auto& [joint, range] : ranges)
    if (std::exchange(range.known, false)) range.moved = true;
  dialogue_.say("  " + options_.port + " is gone: plug the adapter in again. What was measured is kept");
}

/// True while the adapter is gone. Looks for it now and then.
bool Commissioning::reopen_if_gone() {
  if (bus_) return false;
  if (++looks_ % kLooksToReopen != 0) return true;
  try {
    open(options_.port, baud_);
  } catch (const Error&) {  // not there yet
    return true;
  }
  dialogue_.say("  " + options_.port + " is back");
  return false;
}

void Commissioning::save(const Ranges& ranges) const {
  Progress progress;
  for (const auto& [joint, range] : ranges)
    if (range.max - range.min >= kLeastRange) progress.joints[joint] = {range.min, range.max, {}, {}};
  if (options_.calibration.empty()) return;
  if (progress.joints.empty())
    remove_progress(options_.calibration);
  else
    write_progress(options_.calibration, family_, progress);
}

/// Chooses homing such that the middle of the range is the middle of the count.
int Commissioning::homing_without_wrap(const std::string& joint, Range& range) {
  const int turn = family_.steps_per_turn, id = id_of(joint);
  const int middle = (range.min + range.max) / 2;
  const int shift = turn / 2 - middle;
  int homing = get(id, family_.homing) + static_cast<int>(family_.homing_sign) * shift;
  homing = (homing % turn + turn + turn / 2) % turn - turn / 2;  // -2048 … 2047
  homing = homing == -turn / 2 ? homing + 1 : homing;
  if (std::abs(homing) > family_.homing_limit)
    throw Error("wrap",
                joint + " turns through the end of its count, and this family cannot move the count that far",
                "take its horn off and put it on turned by half a turn, then run this again");
  range.min += shift;
  range.max += shift;
  range.turns += shift;
  return homing;
}

/// Measures the ranges of all joints; those that an earlier run has measured need no further motion.
Commissioning::Ranges Commissioning::measure_ranges(const std::optional<Progress>& earlier) {
  Ranges ranges;
  std::vector<std::string> known;
  for (const std::string& joint : options_.joints) {
    Range& range = ranges[joint];
    if (!earlier || !earlier->joints.contains(joint)) continue;
    const Progress::Joint& before = earlier->joints.at(joint);
    range.min = before.min;
    range.max = before.max;
    range.moved = true;
    known.push_back(joint);
  }
  if (!known.empty())
    dialogue_.say("an earlier run has measured " + join(known, ", ") + "; it continues from " +
                  progress_file(options_.calibration).string() + " (remove this file to begin anew)");
  for (int attempt = 0;; ++attempt) {
    const auto unmoved = [&] {
      std::vector<std::string> out;
      for (const std::string& joint : options_.joints)
        if (ranges[joint].max - ranges[joint].min < kLeastRange) out.push_back(joint);
      return out;
    };
    if (unmoved().empty()) break;
    dialogue_.ask(known.empty() ? "Move every joint slowly from stop to stop, then press Enter"
                                : "Move the other joints slowly from stop to stop, then press Enter",
                  [&] { follow(ranges); });
    save(ranges);
    const std::vector<std::string> left = unmoved();
    if (left.empty()) break;
    if (attempt == kTries)
      throw Error("not-moved", join(left, ", ") + " did not move", "run this again: it continues with them");
    dialogue_.say("not moved yet: " + join(left, ", "));
  }
  return ranges;
}

void Commissioning::calibrate() {
  if (!bus_) find();
  std::optional<Progress> progress = read_progress(options_.calibration, family_);
  take_torque_off(ids(), "the joints are moved by hand");
  if (progress && progress->stage == Progress::Stage::writing)
    dialogue_.say("an earlier run has measured everything: its values are written now");
  else
    progress = choose(measure_ranges(progress));
  write_registers(*progress);
  write_calibration();
  if (!options_.calibration.empty()) remove_progress(options_.calibration);
  dialogue_.say("calibration written to " + options_.calibration.string());
}

/// Asks for zero and decides what is written. Saves the decision: from then on a later run only writes.
Progress Commissioning::choose(Ranges ranges) {
  const std::string zero =
      dialogue_.ask("Hold the arm in its zero pose and press Enter, or type m for the middle of each range",
                    [&] { follow(ranges); });
  follow(ranges);
  if (!bus_)
    throw Error("no-port", options_.port + " is gone", "plug it in and run this again: it continues");
  Progress out;
  out.stage = Progress::Stage::writing;
  for (const std::string& joint : options_.joints) {
    Range& range = ranges[joint];
    Progress::Joint& to = out.joints[joint];
    const int turn = family_.steps_per_turn;
    if (range.max - range.min >= turn - kLeastRange) {
      range.min = 0;
      range.max = turn - 1;
      range.turns = 0;
      dialogue_.say(joint + " turns all round");
    } else if (range.min < 0 || range.max >= turn) {
      try {
        to.homing = homing_without_wrap(joint, range);
      } catch (const Error&) {  // it must be moved again, whatever the remedy
        ranges.erase(joint);
        save(ranges);
        throw;
      }
    }
    to.min = range.min;
    to.max = range.max;
    to.zero = equal_ignoring_case(trim(zero), "m") ? (range.min + range.max) / 2 : range.now();
  }
  if (!options_.calibration.empty()) write_progress(options_.calibration, family_, out);
  return out;
}

/// Every write may be repeated.
void Commissioning::write_registers(const Progress& progress) {
  for (const std::string& joint : options_.joints) {
    const auto found = progress.joints.find(joint);
    if (found == progress.joints.end())
      throw Error(
          "not-moved", "the unfinished calibration has no " + joint,
          "remove " + progress_file(options_.calibration).string() + " and calibrate from the beginning");
    const Progress::Joint& from = found->second;
    const int id = id_of(joint);
    JointCalibration& out = calibration_[joint];
    out.id = id;
    out.min = from.min;
    out.max = from.max;
    out.zero = from.zero;
    if (from.homing) {
      dialogue_.say(joint + " turns through the end of its count: homing is set to " +
                    std::to_string(*from.homing));
      set_lasting(id, family_.homing, *from.homing);
    }
    set_lasting(id, family_.min_limit, from.min);
    set_lasting(id, family_.max_limit, from.max);
    dialogue_.say(joint + ": " + std::to_string(from.min) + " to " + std::to_string(from.max) + ", zero at " +
                  std::to_string(*out.zero));
  }
}

int Commissioning::restore(const std::filesystem::path& file) {
  const Yaml yaml = Yaml::load(file.string());
  Problems problems;
  if (yaml["polyarm"].text("") != "servo_backup/1" || yaml["family"].text("") != family_.name)
    problems.error("wrong-kind", yaml.where(),
                   std::string("this is not a servo_backup/1 of ") + family_.name + " servos");
  problems.throw_if_errors();
  if (!bus_) find();
  struct Write {
    int id;
    Register reg;
    std::int32_t value;
  };
  std::vector<Write> writes;
  for (const std::string& key : yaml["servos"].keys()) {
    const Yaml servo = yaml["servos"][key];
    const auto id = parse_number(key);
    if (!id || *id < 0 || *id > family_.highest_id || !look_at(static_cast<int>(*id), baud_)) {
      problems.error("no-servo", servo.where(), "servo " + key + " of the backup does not answer",
                     "connect it");
      continue;
    }
    const int own = static_cast<int>(*id);
    if (const int model = get(own, family_.model); model != servo["model"].number(Dimension::none, model))
      problems.error("wrong-model", servo.where(),
                     "servo " + key + " is another model than that of the backup");
    for (const std::string& name : servo["registers"].keys()) {
      const auto named = std::find_if(family_.lasting.begin(), family_.lasting.end(),
                                      [&](const NamedRegister& r) { return name == r.name; });
      if (named == family_.lasting.end())
        problems.error("unknown-register", servo["registers"].key_location(name),
                       "there is no register '" + name + "'");
      else
        collect(problems, [&] {
          const double value = servo["registers"][name].number();
          if (get(own, named->reg) != value)
            writes.push_back({own, named->reg, static_cast<std::int32_t>(value)});
        });
    }
  }
  problems.throw_if_errors();  // all or nothing
  std::vector<int> ids;
  for (const Write& write : writes)
    if (ids.empty() || ids.back() != write.id) ids.push_back(write.id);
  if (!writes.empty()) take_torque_off(ids, "registers are written back");
  for (const Write& write : writes) set_lasting(write.id, write.reg, write.value);
  dialogue_.say(std::to_string(writes.size()) + " registers were different and are as in " + file.string() +
                " again");
  return static_cast<int>(writes.size());
}

void Commissioning::read_calibration() {
  std::error_code ignored;
  if (options_.calibration.empty() || !std::filesystem::exists(options_.calibration, ignored)) return;
  const Yaml yaml = Yaml::load(options_.calibration.string());
  if (yaml["polyarm"].text("") != "servo_calibration/1" || yaml["family"].text("") != family_.name)
    throw Error(Problem{"wrong-kind", yaml.where(),
                        std::string("this is not a servo_calibration/1 of ") + family_.name + " servos",
                        "name another file with --calibration"});
  for (const std::string& joint : yaml["joints"].keys()) {
    const Yaml entry = yaml["joints"][joint];
    const auto number = [&](const char* key) -> std::optional<int> {
      if (!entry.has(key)) return std::nullopt;
      return static_cast<int>(entry[key].number());
    };
    JointCalibration& out = calibration_[joint];
    out.id = number("id").value_or(-1);
    out.model = number("model");
    out.zero = number("zero");
    out.min = number("min");
    out.max = number("max");
    out.direction = number("direction");
  }
}

void Commissioning::write_calibration() const {
  std::string text = std::string("polyarm: servo_calibration/1\nfamily: ") + family_.name +
                     "\n# id and model of each joint's servo; zero, min and max in steps of 1/" +
                     std::to_string(family_.steps_per_turn) +
                     " turn.\n# direction: -1 where a joint turns the wrong " + "way.\njoints:\n";
  for (const std::string& joint : options_.joints) {
    const auto found = calibration_.find(joint);
    if (found == calibration_.end() || found->second.id < 0) continue;
    const JointCalibration& c = found->second;
    text += "  " + joint + ": {id: " + std::to_string(c.id);
    const auto add = [&](const char* key, const std::optional<int>& value) {
      if (value) text += std::string(", ") + key + ": " + std::to_string(*value);
    };
    add("model", c.model);
    add("zero", c.zero);
    add("min", c.min);
    add("max", c.max);
    add("direction", c.direction);
    text += "}\n";
  }
  write_file_atomically(options_.calibration, text);
}

}  // namespace polyarm::servo_bus
