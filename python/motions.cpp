/// Motions for Python: from state to state, and through waypoints. polyarm/motion.py makes the arrays.
#include <algorithm>
#include <memory>
#include <span>

#include "polyarm/paths/joint_path.hpp"
#include "polyarm/timing/timing.hpp"
#include "polyarm/trajectory/state_to_state.hpp"
#include "python/bindings.hpp"

namespace polyarm::python {

namespace {
std::vector<trajectory::MotionLimits> limits_of(const Numbers& limits, std::size_t axes) {
  if (limits.ndim() != 2 || limits.shape(0) != 3 || std::size_t(limits.shape(1)) != axes)
    wrong_shape("limits have one velocity, acceleration and jerk for each joint");
  std::vector<trajectory::MotionLimits> out;
  for (std::size_t j = 0; j < axes; ++j)
    out.push_back(trajectory::MotionLimits::symmetric(limits.at(0, j), limits.at(1, j), limits.at(2, j)));
  return out;
}

/// From state to state. Rows of a state: position, velocity, acceleration.
class DirectMotion {
 public:
  DirectMotion(const Numbers& start, const Numbers& target, const Numbers& limits,
               const std::string& synchronization, double minimum_duration) {
    const std::size_t axes = start.ndim() == 2 ? std::size_t(start.shape(1)) : 0;
    trajectory::MotionOptions options;
    options.minimum_duration = minimum_duration;
    options.synchronization =
        synchronization == "none"   ? trajectory::Synchronization::none
        : synchronization == "time" ? trajectory::Synchronization::time
        : synchronization == "phase"
            ? trajectory::Synchronization::phase
            : throw Error("bad-value", "there is no synchronization '" + synchronization + "'",
                          "use none, time or phase");
    const auto from = states_of(start, axes), to = states_of(target, axes);
    const auto status = motion_->plan(from, to, limits_of(limits, axes), options);
    if (status != trajectory::MotionStatus::ok)
      throw Error(text_of(status), std::string("no motion from state to state: ") + trajectory::name(status),
                  "see the limits and the states in docs/python.md");
  }
  double duration() const { return motion_->duration(); }
  std::size_t joints() const { return motion_->axes(); }
  Numbers sample(const Numbers& times) const {
    const std::size_t count = std::size_t(times.size()), n = joints();
    Numbers out({std::size_t{4}, count, n});
    std::vector<trajectory::MotionState> state(n);
    for (std::size_t i = 0; i < count; ++i) {
      motion_->sample(times.data()[i], state);
      for (std::size_t j = 0; j < n; ++j) {
        out.mutable_at(0, i, j) = state[j].position;
        out.mutable_at(1, i, j) = state[j].velocity;
        out.mutable_at(2, i, j) = state[j].acceleration;
        out.mutable_at(3, i, j) = jerk_at(j, times.data()[i]);
      }
    }
    return out;
  }

 private:
  static std::string text_of(trajectory::MotionStatus status) {
    switch (status) {
      case trajectory::MotionStatus::wrong_size:
        return "wrong-size";
      case trajectory::MotionStatus::bad_number:
        return "bad-number";
      case trajectory::MotionStatus::bad_limit:
        return "bad-limit";
      default:
        return "target-outside";
    }
  }
  static std::vector<trajectory::MotionState> states_of(const Numbers& state, std::size_t axes) {
    if (state.ndim() != 2 || state.shape(0) != 3 || std::size_t(state.shape(1)) != axes)
      wrong_shape("a state has one position, velocity and acceleration for each joint");
    std::vector<trajectory::MotionState> out;
    for (std::size_t j = 0; j < axes; ++j) out.push_back({state.at(0, j), state.at(1, j), state.at(2, j)});
    return out;
  }
  double jerk_at(std::size_t axis, double t) const {
    const trajectory::AxisMotion& motion = motion_->axis(axis);
    if (t < 0 || t >= motion.duration()) return 0;
    std::size_t i = motion.pieces();
    while (i > 1 && motion.begin_of(i - 1) > t) --i;
    return motion.jerk_of(i - 1);
  }
  std::unique_ptr<trajectory::StateToState> motion_ = std::make_unique<trajectory::StateToState>();
};

/// Through waypoints: sections from stop to stop.
class PathMotion {
 public:
  PathMotion(const Numbers& waypoints, const Numbers& radii, const Numbers& limits, bool spline) {
    if (waypoints.ndim() != 2 || radii.size() != waypoints.shape(0))
      wrong_shape("waypoints have one row and one radius each");
    joints_ = std::size_t(waypoints.shape(1));
    const auto bounds = limits_of(limits, joints_);
    std::vector<paths::JointWaypoint> points;
    for (py::ssize_t i = 0; i < waypoints.shape(0); ++i)
      points.push_back({{waypoints.data(i), waypoints.data(i) + joints_}, radii.data()[i], {}});
    const py::gil_scoped_release others;
    std::vector<std::shared_ptr<const paths::Path>> ways;
    auto made = spline ? paths::joint_spline(points) : paths::joint_lines(points);
    for (auto& section : made.sections) ways.emplace_back(std::move(section));
    for (auto& way : ways) {
      begins_.push_back(duration_);
      sections_.push_back(timing::timed(std::move(way), bounds));
      duration_ += sections_.back().duration();
    }
  }
  double duration() const { return duration_; }
  std::size_t joints() const { return joints_; }
  Numbers sample(const Numbers& times) const {
    const std::size_t count = std::size_t(times.size());
    Numbers out({std::size_t{4}, count, joints_});
    std::size_t hint = 0, before = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double t = times.data()[i];
      const auto after = std::upper_bound(begins_.begin(), begins_.end(), t);
      const std::size_t k = after == begins_.begin() ? 0 : std::size_t(after - begins_.begin()) - 1;
      if (k != before) hint = 0;
      before = k;
      const auto row = [&](std::size_t quantity) {
        return std::span<double>(out.mutable_data(quantity, i, 0), joints_);
      };
      sections_[k].sample(t - begins_[k], row(0), row(1), row(2), row(3), hint);
    }
    return out;
  }

 private:
  std::size_t joints_ = 0;
  double duration_ = 0;
  std::vector<double> begins_;
  std::vector<timing::TimedPath> sections_;
};
}  // namespace

void add_motions(py::module_& module) {
  py::class_<DirectMotion>(module, "DirectMotion")
      .def(py::init<const Numbers&, const Numbers&, const Numbers&, const std::string&, double>())
      .def_property_readonly("duration", &DirectMotion::duration)
      .def_property_readonly("joints", &DirectMotion::joints)
      .def("sample", &DirectMotion::sample);
  py::class_<PathMotion>(module, "PathMotion")
      .def(py::init<const Numbers&, const Numbers&, const Numbers&, bool>())
      .def_property_readonly("duration", &PathMotion::duration)
      .def_property_readonly("joints", &PathMotion::joints)
      .def("sample", &PathMotion::sample);
}

}  // namespace polyarm::python
