/// Functions whose results depend on the running program: its robot, its clock, its series of random numbers.
#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/language/compliance.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

namespace {
[[noreturn]] void refuse(std::string what, std::string advice = {}) {
  throw OperationError{"bad-value", std::move(what), std::move(advice)};
}

Value wrench_record(const std::array<double, 6>& w) {
  data::Record out;
  constexpr std::array kAxes = {"x", "y", "z", "rx", "ry", "rz"};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    out.names.emplace_back(kAxes[i]);
    out.values.emplace_back(data::Number{w[i], i < 3 ? Dimension::force : Dimension::torque});
  }
  return out;
}

}  // namespace

Value Interpreter::live_call(const Task& task, const Function& function) {
  const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
  switch (function.live) {
    case Live::random:
      return random();
    case Live::clock:
      return data::Number{1e-9 * static_cast<double>(host_.now() - began_), Dimension::time};
    case Live::here_joints:
      return host_.here_joints(use.robot);
    case Live::ik:
      return joints_at(use);
    case Live::force: {
      const std::array<double, 6> w = host_.wrench(use.robot);
      return data::Number{norm(Vec3{w[0], w[1], w[2]}), Dimension::force};
    }
    case Live::wrench:
      return wrench_record(host_.wrench(use.robot));
    case Live::zero_force:
      host_.zero_force(use.robot);
      return true;
    case Live::comply:
      host_.comply(use.robot, compliance_of(arguments_));
      return true;
    case Live::stiff:
      host_.stiff(use.robot);
      return true;
    case Live::met:
      return task.until_met;
    case Live::travelled:
      return data::Number{task.travelled, Dimension::length};
    case Live::next_part:
      return host_.next_part(*arguments_[0].as_text(), use.robot);
    case Live::waiting_parts:
      return host_.waiting_parts(*arguments_[0].as_text());
    case Live::missed_parts:
      return host_.missed_parts(*arguments_[0].as_text());
    case Live::add_part:
      host_.add_part(*arguments_[0].as_text(), arguments_[1].as_point()->pose);
      return true;
    case Live::rows_of:
      return host_.rows_of(*arguments_[0].as_text());
    case Live::is_connected:
      return host_.is_connected(*arguments_[0].as_text());
    case Live::has_line:
      return host_.has_line(*arguments_[0].as_text());
    case Live::next_line:
      return host_.next_line(*arguments_[0].as_text());
    case Live::send_text:
      host_.send_text(*arguments_[0].as_text(), *arguments_[1].as_text());
      return true;
    default:
      return pose_at(use);
  }
}

Value Interpreter::joints_at(const MoveDefaults& use) const {
  Value place = arguments_[0];
  const data::Point* const point = place.as_point();
  if (use.frame_pose && point && point->frame().empty()) {  // the host takes it in the frame around this one
    data::Point outer = *point;
    outer.pose = *use.frame_pose * outer.pose;
    place = std::move(outer);
  }
  return host_.joints_at(place, arguments_[1].as_joints(), use.robot, use.tool, use.named_frame());
}

Value Interpreter::pose_at(const MoveDefaults& use) const {
  if (!arguments_[0].as_joints()) refuse("fk() takes a joint state, here is " + described(arguments_[0]));
  Value out = host_.pose_at(*arguments_[0].as_joints(), use.robot, use.tool, use.named_frame());
  if (use.frame_pose && out.as_point())
    out = data::Point{inverse(*use.frame_pose) * out.as_point()->pose, false};
  return out;
}

/// SplitMix64: the same series for the same seed on every machine.
Value Interpreter::random() {
  std::uint64_t z = (random_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  const double share = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  const data::Number a = *arguments_[0].as_number(), b = *arguments_[1].as_number();
  if (a.dimension != b.dimension || b.value < a.value)
    refuse("random() goes from a smaller to a larger number of one unit, here are " + arguments_[0].text() + " and " +
               arguments_[1].text(),
           "write such as random(1mm, 5mm)");
  return data::Number{a.value + share * (b.value - a.value), a.dimension};
}

}  // namespace polyarm::program
