#pragma once
#include <atomic>
#include <memory>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/force/admittance_rule.hpp"
#include "polyarm/force/robot_user.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// Makes a robot yield to forces at its sensor, as ros2_control's AdmittanceController does: it stands
/// between a controller of joints and the joints, and adds an offset to their references.
///
/// Inputs: `joint_references` (trajectory_msgs/JointTrajectoryPoint) and `wrench_reference`
/// (geometry_msgs/WrenchStamped in the sensor's frame, added to what is measured). References:
/// `<name>/<joint>/position`, `…/velocity`. Output: `status` (control_msgs/AdmittanceControllerState).
///
/// It starts at the last command, or where the joints are, and never jumps. During a stop its offset stays.
class AdmittanceController : public Controller, public RobotUser {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  bool standing() const noexcept override { return standing_.load(std::memory_order_relaxed); }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

  const AdmittanceRule& rule() const { return *rule_; }  ///< control thread

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  struct JointPort {
    JointFacts facts;
    std::size_t position_state = kNone, position_command = kNone, velocity_command = kNone;
    std::size_t position_reference = kNone, velocity_reference = kNone;
  };

  // configuration
  void read_joints(ControllerContext& context);
  void claim(ControllerContext& context, const std::vector<std::string>& command_joints);
  void read_sensor_ports(ControllerContext& context);
  void read_axes(Parameters& p);
  void read_gravity(Parameters& p);
  void make_rule(ControllerContext& context);
  int link_of(Parameters& p, const description::RobotModel& model, const std::string& key, bool may_be_world);
  void make_output();

  // control thread
  void take_inputs() noexcept;
  void measure() noexcept;
  SixVector wrench() noexcept;
  void command() noexcept;
  void publish(const Cycle& cycle) noexcept;

  std::vector<JointPort> joints_;
  std::array<std::size_t, 6> sensor_{};  // states
  std::string base_frame_, sensor_frame_;
  AdmittanceParameters parameters_;
  // changeable
  double joint_damping_ = 5, filter_ = 0.05, weight_ = 0;
  std::unique_ptr<AdmittanceRule> rule_;
  Output* status_ = nullptr;

  // between the threads
  struct Point {
    std::vector<double> positions, velocities;  // empty: not commanded
  };
  realtime::Latest<Point> points_inbox_;
  realtime::Latest<SixVector> wrench_inbox_;
  std::atomic<bool> standing_{true};

  // control thread
  std::vector<double> measured_, reference_, reference_velocity_, last_command_;
  SixVector requested_wrench_{};
};

}  // namespace polyarm::controllers
