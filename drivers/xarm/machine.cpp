#include "drivers/xarm/machine.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::xarm {

namespace {

constexpr double kEndless = 360, kVelocity = 180;  // degrees, of a joint without limits
constexpr double kFollows = 0.6;                   // of the way to the command, in each cycle
constexpr double kThere = 1e-5;                    // degrees
constexpr double kTolerance = 1.05;                // of a speed limit, in servo mode
constexpr double kJerkTime = 0.05;                 // s, to the acceleration of a move
constexpr double kVelocityAcceleration = 500;      // degrees/s², in velocity mode
constexpr int kSpeedError = 24, kLimitError = 23, kNoPathError = 21;
constexpr std::size_t kMostMoves = 1024;    // in the queue
constexpr double kCoasting = 0.15;          // s, of a stop
constexpr double kAlone = 0.1;              // s, after which a move with a radius counts as the last one
constexpr double kJointAcceleration = 500;  // degrees/s²

/// Types as the maker counts them.
int type_of(const std::string& model, std::size_t axes) {
  if (model.find("lite") != std::string::npos) return 9;
  if (model.find("850") != std::string::npos) return 12;
  return static_cast<int>(axes);
}

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  const auto joints = wire::revolute_joints(model, 5, kWireJoints, "ufactory/xarm_6");
  MachineFacts out;
  out.model = model.name.substr(model.name.find('/') + 1);
  out.axes = joints.size();
  out.type = type_of(out.model, out.axes);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const description::JointLimits& limits = joints[i]->limits;
    out.lower[i] = limits.lower ? *limits.lower * wire::kDegrees : -kEndless;
    out.upper[i] = limits.upper ? *limits.upper * wire::kDegrees : kEndless;
    out.velocity[i] = limits.velocity ? *limits.velocity * wire::kDegrees : kVelocity;
  }
  const int flange = wire::flange_link(model, joints.back()->child_link);
  out.chain = std::make_shared<const kinematics::Chain>(model, flange);
  return out;
}

Machine::Machine(MachineOptions options)
    : options_(std::move(options)), shaper_(options_.cycle_ms / 1000.0), player_(played_arm(), kMostMoves) {
  for (std::size_t i = options_.facts.axes; i < kWireJoints; ++i) options_.start[i] = 0;
  command_ = measured_ = target_ = options_.start;
}

// --- people -----------------------------------------------------------------------------------------------

void Machine::stop_motion() {
  if (plays() && !stands()) coasting_ = kCoasting;
  moves_.clear();
  player_.forget();
  next_.reset();
  has_target_ = had_target_ = planning_ = false;
  velocity_ = {};
}

void Machine::emergency(int code, bool on) {
  if (!on) {
    pressed_ = 0;
    return;
  }
  pressed_ = code;
  enabled_ = false;
  raise_error(code);
}

void Machine::raise_error(int code) {
  error_ = code;
  state_ = State::stopped;
  stop_motion();
}

void Machine::switch_motors(bool on) {
  enabled_ = on;
  if (on) return;
  state_ = State::stopped;
  stop_motion();
}

/// Another mode wants a new start, as at the maker's.
void Machine::set_mode(int mode) {
  if (mode == static_cast<int>(mode_)) return;
  stop_motion();
  mode_ = static_cast<Mode>(mode);
  if (is_ready()) state_ = State::reset;
}

void Machine::set_state(int state) {
  has_target_ = false;
  if (state == 3) {
    if (is_ready()) state_ = State::paused;
    return;
  }
  if (state == 4) {
    if (ignore_stop) return;
    state_ = State::stopped;
    stop_motion();
    return;
  }
  if (state != 0 || error_ != 0 || !enabled_ || refuse_state) return;
  state_ = State::standing;
}

void Machine::push_by_hand(const Seven& change) {
  for (std::size_t i = 0; i < kWireJoints; ++i) command_[i] += change[i];
  measured_ = command_;
  player_.interrupt();
  speed_ = {};
  has_target_ = planning_ = false;
}

void Machine::set_input(int number, bool on) {
  inputs_ = on ? inputs_ | 1u << number : inputs_ & ~(1u << number);
}

void Machine::set_tool_input(int number, bool on) {
  tool_inputs_ = on ? tool_inputs_ | 1u << number : tool_inputs_ & ~(1u << number);
}

// --- motion -----------------------------------------------------------------------------------------------

bool Machine::within_limits(const Seven& degrees) const {
  for (std::size_t i = 0; i < options_.facts.axes; ++i)
    if (degrees[i] < options_.facts.lower[i] - kThere || degrees[i] > options_.facts.upper[i] + kThere)
      return false;
  return true;
}

/// Servo mode: the last target at once, if no joint is too fast for that.
void Machine::follow_target() {
  had_target_ = has_target_;
  if (!has_target_) return;
  for (std::size_t i = 0; i < options_.facts.axes; ++i)
    if (std::abs(target_[i] - command_[i]) > options_.facts.velocity[i] * period() * kTolerance)
      return raise_error(kSpeedError);
  command_ = target_;
  has_target_ = false;
}

void Machine::follow_velocity() {
  if (!planning_) shaper_.begin(command_);
  planning_ = true;
  const double step = kVelocityAcceleration * period();
  for (std::size_t i = 0; i < options_.facts.axes; ++i) {
    const double now = shaper_.velocity()[i];
    command_[i] += std::clamp(velocity_[i], now - step, now + step) * period();
  }
  wire::AxisLimitsOf<7> wide;
  for (auto& row : wide.of) row.fill(1e12);
  shaper_.next(command_, wide);  // it only keeps the speed
  if (!within_limits(command_)) raise_error(kLimitError);
}

/// Position mode: one move after the other, each joint by itself.
void Machine::plan() {
  if (moves_.empty()) return;
  if (!planning_) shaper_.begin(command_);
  planning_ = true;
  const Move& move = moves_.front();
  wire::AxisLimitsOf<7> limits;
  limits.of[0].fill(move.speed);
  limits.of[1].fill(move.acceleration);
  limits.of[2].fill(move.acceleration / kJerkTime);
  command_ = shaper_.next(move.target, limits);
  if (command_ != move.target || !shaper_.still()) return;
  moves_.pop_front();
  planning_ = false;
}

// --- moves that it interpolates itself --------------------------------------------------------------------

forward::PlayedArm Machine::played_arm() {
  forward::PlayedArm out;
  out.q = [this]() -> const Six& {
    for (std::size_t i = 0; i < played_.size(); ++i) played_[i] = command_[i] / wire::kDegrees;
    return played_;
  };
  out.still = [this] { return stands(); };
  out.may_move = [this] { return enabled_ && error_ == 0 && state_ <= State::paused; };
  out.follow = [this](const Six& q) { next_ = q; };
  out.refuse = [this] { raise_error(kNoPathError); };
  out.ended = [](int) {};
  out.flange = [this](const Six& q, std::array<double, 36>& J) {
    return options_.facts.chain->jacobian(q, J);
  };
  for (std::size_t i = 0; i < out.velocity.size(); ++i) {
    out.velocity[i] = options_.facts.velocity[i] / wire::kDegrees;
    out.acceleration[i] = kJointAcceleration / wire::kDegrees;
  }
  return out;
}

bool Machine::stands() const {
  return coasting_ <= 0 && std::all_of(speed_.begin(), speed_.end(), [](double v) { return v == 0; });
}

/// A joint that is too fast or beyond its limit is an error. False: there is one.
bool Machine::drive(const Six& q) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double next = q[i] * wire::kDegrees;
    const bool fast = std::abs(next - command_[i]) > options_.facts.velocity[i] * period() * kTolerance;
    if (fast || next < options_.facts.lower[i] - kThere || next > options_.facts.upper[i] + kThere) {
      raise_error(fast ? kSpeedError : kLimitError);
      return false;
    }
  }
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double next = q[i] * wire::kDegrees;
    speed_[i] = (next - command_[i]) / period();
    command_[i] = next;
  }
  return true;
}

/// A stop of the controller, without a path.
void Machine::coast() {
  const double dt = period();
  const double left = coasting_ > dt ? 1 - dt / coasting_ : 0;
  coasting_ = std::max(0.0, coasting_ - dt);
  for (std::size_t i = 0; i < options_.facts.axes; ++i) {
    speed_[i] *= left;
    command_[i] = std::clamp(command_[i] + speed_[i] * dt, options_.facts.lower[i], options_.facts.upper[i]);
  }
}

/// Position mode: a path of moves, with rounded corners. A pause scales its time down to rest.
void Machine::play_moves() {
  player_.change_pace(state_ == State::paused ? 0 : 1, period());
  alone_ = player_.waiting() == 1 ? alone_ + 1 : 0;
  if (alone_ * period() > kAlone) player_.end_last();
  next_.reset();
  player_.step(period());
  if (const auto next = std::exchange(next_, std::nullopt))
    drive(*next);
  else if (error_ == 0)
    speed_ = {};
}

void Machine::measure() {
  for (std::size_t i = 0; i < kWireJoints; ++i) {
    const double before = measured_[i];
    measured_[i] += kFollows * (command_[i] - measured_[i]);
    if (std::abs(command_[i] - measured_[i]) < kThere) measured_[i] = command_[i];
    fastest_ = std::max(fastest_, std::abs(measured_[i] - before) / period());
  }
}

void Machine::step() {
  const Seven before = command_;
  if (is_ready() && coasting_ <= 0) {
    if (mode_ == Mode::servo) follow_target();
    if (mode_ == Mode::joint_velocity) follow_velocity();
    if (!plays() && (mode_ == Mode::position || mode_ == Mode::online_joint)) plan();
  }
  if (coasting_ > 0)
    coast();
  else if (plays())
    play_moves();
  else
    speed_ = {};
  if (other_moves) command_[0] += 0.05;
  for (std::size_t i = 0; i < kWireJoints; ++i) jump_ = std::max(jump_, std::abs(command_[i] - before[i]));
  measure();
  if (is_ready()) {
    const bool moves = command_ != before || queued() > 0 || measured_ != command_;
    state_ = moves ? State::moving : State::standing;
  }
  for (const auto& [output, input] : wires_) set_input(input, outputs_ >> output & 1);
}

// --- reports ----------------------------------------------------------------------------------------------

Six Machine::pose_of(const Seven& degrees) const {
  if (!options_.facts.chain) return {};
  std::vector<double> q(options_.facts.axes);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = degrees[i] / wire::kDegrees;
  const Pose flange = options_.facts.chain->forward(q);
  const Pose offset{{tcp_offset_[0] * 1e-3, tcp_offset_[1] * 1e-3, tcp_offset_[2] * 1e-3},
                    from_rpy(tcp_offset_[3], tcp_offset_[4], tcp_offset_[5])};
  const Pose tcp = flange * offset;
  const Vec3 rpy = to_rpy(tcp.rotation);
  return {tcp.position.x * 1e3, tcp.position.y * 1e3, tcp.position.z * 1e3, rpy.x, rpy.y, rpy.z};
}

Report Machine::report() const {
  Report out;
  out.state = state_;
  out.mode = mode_;
  out.queued = static_cast<int>(queued());
  for (std::size_t i = 0; i < kWireJoints; ++i) out.position[i] = measured_[i] / wire::kDegrees;
  out.pose = pose_of(measured_);
  out.has_force = true;
  return out;
}

SlowReport Machine::slow_report() const {
  SlowReport out;
  const auto all = static_cast<std::uint8_t>((1u << options_.facts.axes) - 1);
  out.brakes = out.enabled = enabled_ ? all : 0;
  out.error = error_;
  out.warning = warning_;
  out.tcp_offset = tcp_offset_;
  out.load = load_[0];
  out.load_centre = {load_[1], load_[2], load_[3]};
  out.collision_sensitivity = collision_;
  out.teach_sensitivity = teach_;
  out.gravity = gravity_;
  out.type = options_.facts.type;
  out.axes = static_cast<int>(options_.facts.axes);
  out.version = version();
  out.inputs = static_cast<std::uint16_t>(inputs_);
  out.outputs = static_cast<std::uint16_t>(outputs_);
  return out;
}

}  // namespace polyarm::xarm
