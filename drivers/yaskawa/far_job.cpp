#include "drivers/yaskawa/far_job.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "drivers/wire/six_axes.hpp"
#include "drivers/yaskawa/inform.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::yaskawa {

using wire::scaled;
using Kind = hardware::ForwardMove::Kind;
using Reader = wire::OrderedReader;
using Writer = wire::OrderedWriter;
using wire::ByteOrder;

namespace {

constexpr int kLinesOfCycle = 64;
constexpr double kRamp = 0.2;              // s, of an axis to its full speed
constexpr double kLineAcceleration = 2.5;  // m/s²
constexpr double kTooFast = 1.1;           // of the speed of an axis
constexpr std::uint32_t kSegment = 4414, kPulseLimit = 4416;

HsesCommand command_of(char letter) {
  return letter == 'B'   ? HsesCommand::byte
         : letter == 'I' ? HsesCommand::integer
                         : HsesCommand::double_integer;
}

/// "D080" → 80
std::uint16_t number_in(const std::string& name) {
  return static_cast<std::uint16_t>(parse_number(name.substr(1)).value_or(0));
}

bool is_variable(const std::string& word) {
  return word.size() == 4 && (word[0] == 'B' || word[0] == 'I' || word[0] == 'D') &&
         word.find_first_not_of("0123456789", 1) == std::string::npos;
}

/// "V=I081" → "I081" for "V"
std::optional<std::string> item(const std::vector<std::string>& line, const std::string& name) {
  for (const std::string& word : line)
    if (word.starts_with(name + "=")) return word.substr(name.size() + 1);
  return std::nullopt;
}

}  // namespace

// --- variables ------------------------------------------------------------------------------------------

std::vector<std::uint8_t> Variables::get(Key key, std::size_t size) const {
  const auto found = values_.find(key);
  return found != values_.end() ? found->second : std::vector<std::uint8_t>(size);
}

std::int32_t Variables::number(const std::string& name) const {
  const HsesCommand command = command_of(name[0]);
  const auto bytes = get({static_cast<std::uint16_t>(command), number_in(name)}, 4);
  Reader in(bytes, ByteOrder::little);
  if (command == HsesCommand::byte) return in.u8();
  return command == HsesCommand::integer ? static_cast<std::int16_t>(in.u16()) : in.i32();
}

void Variables::set_number(const std::string& name, std::int32_t value) {
  const HsesCommand command = command_of(name[0]);
  Writer out(ByteOrder::little);
  if (command == HsesCommand::byte)
    out.u8(static_cast<std::uint8_t>(value));
  else if (command == HsesCommand::integer)
    out.u16(static_cast<std::uint16_t>(value));
  else
    out.i32(value);
  set({static_cast<std::uint16_t>(command), number_in(name)}, out.bytes());
}

HsesPosition Variables::place(int number) const {
  const Key key{static_cast<std::uint16_t>(HsesCommand::place), static_cast<std::uint16_t>(number)};
  return decode_position(get(key, 52)).value_or(HsesPosition{});
}

std::uint8_t Variables::signals(int byte) const {
  return get({static_cast<std::uint16_t>(HsesCommand::io), static_cast<std::uint16_t>(byte)}, 1).front();
}

// --- the text of a job ----------------------------------------------------------------------------------

std::vector<std::vector<std::string>> parse_job(const std::string& text) {
  static const std::set<std::string> kKnown{"NOP",  "SET",   "INC",  "MUL",  "DIV",  "JUMP", "TIMER",
                                            "DOUT", "ABORT", "MOVJ", "MOVL", "MOVC", "END"};
  std::vector<std::vector<std::string>> out;
  std::set<std::string> labels;
  bool head = true;
  for (std::string line : split_words(text, "\r\n")) {
    if (head || line[0] == '\'') {
      head = head && line != "NOP";
      continue;
    }
    const auto words = split_words(line, " ");
    if (line[0] == '*' && (words.size() != 1 || line.size() > 9 || !labels.insert(line).second))
      throw Error("bad-job", "the label " + line + " is there twice, or longer than 8 letters");
    if (line[0] != '*' && !kKnown.contains(words[0])) throw Error("bad-job", "unknown line: " + line);
    out.push_back(words);
  }
  for (const auto& words : out)
    if (words[0] == "JUMP" && (words.size() < 2 || !labels.contains(words[1])))
      throw Error("bad-job", "no label for a JUMP");
  return out;
}

// --- motion ---------------------------------------------------------------------------------------------

FarJob::FarJob(Machine& machine, Variables& variables, const std::string& job)
    : machine_(machine),
      variables_(variables),
      job_(parse_job(job)),
      player_({
                  .q = [this]() -> const Six& { return q_ = scaled(machine_.setpoint(), wire::kRadians); },
                  .still = [this] { return machine_.still(); },
                  .may_move = [this] { return machine_.servo_on(); },
                  .follow = [this](const Six& q) { follow(q); },
                  .refuse = [this] { machine_.raise_alarm(kSegment, "EXCESSIVE SEGMENT (LOW SPEED)"); },
                  .ended = [this](int) { ended_ = true; },
                  .flange =
                      [this](const Six& q, std::array<double, 36>& J) {
                        return machine_.options().facts.chain->jacobian(q, J);
                      },
                  .velocity = scaled(machine.options().facts.velocity, wire::kRadians),
                  .acceleration = scaled(machine.options().facts.velocity, wire::kRadians / kRamp),
              },
              1) {}

void FarJob::follow(const Six& q) {
  const MachineFacts& facts = machine_.options().facts;
  const Six next = scaled(q, 1 / wire::kRadians), now = machine_.setpoint();
  for (std::size_t i = 0; i < 6; ++i) {
    if (next[i] < facts.lower[i] - 0.01 || next[i] > facts.upper[i] + 0.01)
      return machine_.raise_alarm(kPulseLimit, "PULSE LIMIT (MIN./MAX.)");
    if (std::abs(next[i] - now[i]) > kTooFast * facts.velocity[i] * machine_.period() + 0.01)
      return machine_.raise_alarm(kSegment, "EXCESSIVE SEGMENT (LOW SPEED)");
  }
  machine_.drive(next);
}

/// The rungs that LADDER.TXT describes.
void FarJob::watch(double dt) {
  const std::uint8_t byte = variables_.signals(kHeartbeatByte);
  const bool open = (byte & kSessionBit) != 0, beats = (byte & kBeatBit) != beat_;
  beat_ = byte & kBeatBit;
  silence_ = !open || beats ? 0 : silence_ + dt;
  const bool wants = !no_ladder && silence_ > watchdog;
  if (wants || held_) machine_.hold(2, wants);
  held_ = wants;
}

void FarJob::step(double dt) {
  watch(dt);
  if (machine_.selections() != selected_) {
    selected_ = machine_.selections();
    next_ = 0;
    waited_ = 0;
    under_way_ = false;
    arc_.clear();
    player_.forget();
  }
  const bool runs = machine_.runs(kMovesJob);
  player_.change_pace(runs ? 1 : 0, dt);
  for (int i = 0; runs && i < kLinesOfCycle && execute(dt); ++i) {
  }
  if (!under_way_) return;
  if (!machine_.servo_on()) return player_.interrupt();
  player_.step(dt);
}

// --- lines ----------------------------------------------------------------------------------------------

std::int32_t FarJob::value(const std::string& word) const {
  if (is_variable(word)) return variables_.number(word);
  return static_cast<std::int32_t>(std::lround(parse_number(word).value_or(0)));
}

bool FarJob::holds(const std::string& condition) const {
  for (const char* sign : {"<>", ">=", "<=", "=", ">", "<"}) {
    const std::size_t at = condition.find(sign);
    if (at == std::string::npos) continue;
    const std::string is = sign;
    const std::int32_t a = value(condition.substr(0, at)), b = value(condition.substr(at + is.size()));
    return is == "<>"   ? a != b
           : is == ">=" ? a >= b
           : is == "<=" ? a <= b
           : is == "="  ? a == b
           : is == ">"  ? a > b
                        : a < b;
  }
  return false;
}

void FarJob::jump(const std::vector<std::string>& line) {
  if (line.size() > 3 && !holds(line[3])) return;
  const auto found = std::find(job_.begin(), job_.end(), std::vector<std::string>{line[1]});
  next_ = static_cast<std::size_t>(found - job_.begin());
}

/// False: nothing more in this cycle.
bool FarJob::execute(double dt) {
  if (under_way_) {
    if (!ended_) return false;
    under_way_ = ended_ = false;
  }
  if (next_ >= job_.size()) return false;
  const auto& line = job_[next_];
  const std::string& what = line[0];
  if (what == "TIMER") {
    const auto time = item(line, "T");
    waited_ += dt;
    if (waited_ < parse_number(time.value_or("0")).value_or(0)) return false;
    waited_ = 0;
  }
  ++next_;
  ++lines_;
  if (what == "JUMP") jump(line);
  if (what == "SET") variables_.set_number(line[1], value(line[2]));
  if (what == "INC") variables_.set_number(line[1], value(line[1]) + 1);
  if (what == "MUL") variables_.set_number(line[1], value(line[1]) * value(line[2]));
  if (what == "DIV") variables_.set_number(line[1], value(line[1]) / std::max(1, value(line[2])));
  if (what == "DOUT") machine_.set_output(value(line[1].substr(4, line[1].size() - 5)), line[2] == "ON");
  if (what == "ABORT" || what == "END") {
    machine_.stop_job();
    next_ = 0;
    return false;
  }
  if (what.starts_with("MOV")) return move(line);
  arc_.clear();
  return what != "TIMER";
}

/// False: a motion is under way.
bool FarJob::move(const std::vector<std::string>& line) {
  const Six& pulses = machine_.options().facts.pulses;
  Six per_radian;
  for (std::size_t i = 0; i < 6; ++i) per_radian[i] = pulses[i] / wire::kRadians;
  forward::PlayedMove out;
  out.goal = radians_of(variables_.place(number_in(line[1])).values, per_radian);
  const double ramp = std::clamp(value(item(line, "ACC").value_or("100")), 20, 100) / 100.0;
  if (line[0] == "MOVJ") {
    out.share = std::clamp(value(item(line, "VJ").value_or("0")), 1, 10'000) / 10'000.0;
    out.acceleration = ramp;
    return start(out);
  }
  player_.set_tool(machine_.tool);
  out.kind = Kind::line;
  out.acceleration = ramp * kLineAcceleration;
  if (const auto turn = item(line, "VR")) out.turn = std::max(value(*turn), 1) * 0.1 * wire::kRadians;
  out.speed = std::max(value(item(line, "V").value_or("1")), 1) * 1e-4;
  if (line[0] == "MOVL") {
    arc_.clear();
    return start(out);
  }
  arc_.push_back(out.goal);
  if (arc_.size() < 3) return true;  // the robot is at the first one
  out.kind = Kind::arc;
  out.via = arc_[1];
  arc_.clear();
  return start(out);
}

bool FarJob::start(forward::PlayedMove move) {
  ended_ = false;
  under_way_ = player_.take(move);
  return !under_way_;
}

}  // namespace polyarm::yaskawa
