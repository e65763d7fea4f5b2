#pragma once
/// Transforms between named frames over time, as tf2 keeps them: for each frame its parent and the poses of
/// the last seconds. A transform of a frame in its parent is T_parent_frame. Any thread; not for a cycle: it
/// locks and allocates.
///
/// Bounded: at most kMostFrames frames with kMostSamples poses each. More frames are refused, older poses
/// dropped.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry_msgs/msg/transform_stamped.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/time.hpp"
#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"

namespace tf2 {

constexpr Duration BUFFER_CORE_DEFAULT_CACHE_TIME = std::chrono::seconds(10);
inline TimePoint time_point_of(const TimePoint& time) {
  return time;
}
inline TimePoint time_point_of(const rclcpp::Time& time) {
  return TimePoint(Duration(time.nanoseconds()));
}
inline TimePoint time_point_of(const builtin_interfaces::msg::Time& time) {
  return time_point_of(rclcpp::Time(time));
}
template <typename Rep, typename Period>
Duration duration_of(const std::chrono::duration<Rep, Period>& span) {
  return std::chrono::duration_cast<Duration>(span);
}
inline Duration duration_of(const rclcpp::Duration& span) {
  return Duration(span.nanoseconds());
}

class BufferCore {
 public:
  using TransformStamped = geometry_msgs::msg::TransformStamped;
  static constexpr std::size_t kMostFrames = 4096, kMostSamples = 4096;

  explicit BufferCore(Duration cache = BUFFER_CORE_DEFAULT_CACHE_TIME) : cache_(cache) {}
  BufferCore(const BufferCore&) = delete;
  BufferCore& operator=(const BufferCore&) = delete;

  /// False if the transform cannot be used: it contains NaN or infinity, its rotation is no unit quaternion,
  /// a frame has no name or is its own parent, its time is negative, it is older than the cache, or there are
  /// too many frames.
  bool setTransform(const TransformStamped& transform, const std::string& /*authority*/,
                    bool is_static = false) {
    const std::string parent = plain(transform.header.frame_id), child = plain(transform.child_frame_id);
    const auto& t = transform.transform.translation;
    const auto& r = transform.transform.rotation;
    const Quaternion rotation(r.x, r.y, r.z, r.w);
    if (parent.empty() || child.empty() || parent == child || !(std::fabs(rotation.length2() - 1) < 1e-2) ||
        !std::isfinite(t.x + t.y + t.z) || transform.header.stamp.sec < 0)
      return false;
    const Sample sample{time_point_of(transform.header.stamp), rotation.normalized(), Vector3(t.x, t.y, t.z)};
    {
      const std::lock_guard lock(mutex_);
      if (!frames_.count(child) && frames_.size() >= kMostFrames) return false;
      if (!insert(frames_[child], parent, sample, is_static)) return false;
    }
    changed_.notify_all();
    tell();
    return true;
  }
  /// Calls `call` after each transform that was taken, in the thread that brought it, as long as what is
  /// returned lives. tf2 has no such function.
  std::shared_ptr<void> on_change(std::function<void()> call) {
    auto kept = std::make_shared<std::function<void()>>(std::move(call));
    const std::lock_guard lock(mutex_);
    listeners_.push_back(kept);
    return kept;
  }

  /// T_target_source at `time`; time 0 is the newest that all frames on the way have. Throws LookupException,
  /// ConnectivityException or ExtrapolationException.
  template <typename Time>
  TransformStamped lookupTransform(const std::string& target, const std::string& source,
                                   const Time& time) const {
    const std::lock_guard lock(mutex_);
    return look_up(target, source, time_point_of(time));
  }
  /// T_target_source of target at one time and source at another; `fixed` does not move in between.
  template <typename Time>
  TransformStamped lookupTransform(const std::string& target, const Time& target_time,
                                   const std::string& source, const Time& source_time,
                                   const std::string& fixed) const {
    const std::lock_guard lock(mutex_);
    TransformStamped out = look_up(target, fixed, time_point_of(target_time));
    const Transform whole =
        transform_of(out) * transform_of(look_up(fixed, source, time_point_of(source_time)));
    out.transform = toMsg(whole), out.child_frame_id = source;
    return out;
  }
  template <typename Time>
  bool canTransform(const std::string& target, const std::string& source, const Time& time,
                    std::string* reason = nullptr) const {
    try {
      lookupTransform(target, source, time);
      return true;
    } catch (const TransformException& e) {
      if (reason) *reason = e.what();
      return false;
    }
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    for (auto at = frames_.begin(); at != frames_.end();)
      at = at->second.fixed ? std::next(at) : frames_.erase(at);
  }
  std::vector<std::string> getAllFrameNames() const {
    const std::lock_guard lock(mutex_);
    std::map<std::string, bool> names;
    for (const auto& [name, frame] : frames_) names[name], names[frame.parent];
    std::vector<std::string> out;
    for (const auto& [name, unused] : names) out.push_back(name);
    return out;
  }
  std::string allFramesAsString() const {
    const std::lock_guard lock(mutex_);
    std::string out;
    for (const auto& [name, frame] : frames_)
      out += "Frame " + name + " exists with parent " + frame.parent + ".\n";
    return out;
  }
  bool _frameExists(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return known(plain(name));
  }
  Duration getCacheLength() const { return cache_; }

 protected:
  /// Waits until `done` is true, at most for `span` of the steady clock.
  template <typename Done>
  bool wait_for(Duration span, Done&& done) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, span, std::forward<Done>(done));
  }
  bool can_now(const std::string& target, const std::string& source, TimePoint time) const {
    try {
      look_up(target, source, time);
      return true;
    } catch (const TransformException&) {
      return false;
    }
  }

 private:
  struct Sample {
    TimePoint time;
    Quaternion rotation;
    Vector3 origin;
  };
  struct Frame {
    std::string parent;
    bool fixed = false;
    std::deque<Sample> samples;  ///< oldest first; one for a static frame
  };

  void tell() {
    std::vector<std::shared_ptr<std::function<void()>>> all;
    {
      const std::lock_guard lock(mutex_);
      for (auto at = listeners_.begin(); at != listeners_.end();) {
        auto call = at->lock();
        at = call ? at + 1 : listeners_.erase(at);
        if (call) all.push_back(std::move(call));
      }
    }
    for (const auto& call : all) (*call)();
  }
  static std::string plain(const std::string& name) {
    return !name.empty() && name[0] == '/' ? name.substr(1) : name;
  }
  bool insert(Frame& frame, const std::string& parent, const Sample& sample, bool is_static) {
    if (is_static || frame.fixed || frame.parent != parent) frame.samples.clear();
    frame.parent = parent, frame.fixed = is_static;
    auto& all = frame.samples;
    if (!all.empty() && sample.time < all.back().time - cache_) return false;
    auto place = all.end();
    while (place != all.begin() && std::prev(place)->time >= sample.time) --place;
    if (place != all.end() && place->time == sample.time)
      *place = sample;
    else
      all.insert(place, sample);
    while (all.size() > 1 && (all.front().time < all.back().time - cache_ || all.size() > kMostSamples))
      all.pop_front();
    return true;
  }
  bool known(const std::string& name) const {
    if (frames_.count(name)) return true;
    for (const auto& [child, frame] : frames_)
      if (frame.parent == name) return true;
    return false;
  }
  /// The frames from `name` up to the root, and the root's name.
  std::pair<std::vector<std::string>, std::string> up(std::string name) const {
    std::vector<std::string> out;
    for (auto found = frames_.find(name); found != frames_.end(); found = frames_.find(name)) {
      out.push_back(name);
      if (out.size() > frames_.size())
        throw LookupException("the frames above '" + out.front() + "' form a circle");
      name = found->second.parent;
    }
    return {std::move(out), std::move(name)};
  }
  TransformStamped look_up(const std::string& target_given, const std::string& source_given,
                           TimePoint time) const {
    const std::string target = plain(target_given), source = plain(source_given);
    for (const std::string& name : {target, source})
      if (!known(name)) throw LookupException("\"" + name + "\" passed to lookupTransform does not exist");
    auto [from_target, root] = up(target);
    auto [from_source, other_root] = up(source);
    if (root != other_root)
      throw ConnectivityException("'" + source + "' and '" + target + "' are not in the same tree of frames");
    while (!from_target.empty() && !from_source.empty() && from_target.back() == from_source.back())
      from_target.pop_back(), from_source.pop_back();
    if (time == TimePoint()) time = newest(from_target, from_source);
    const Transform whole = pose_in_common(from_target, time).inverse() * pose_in_common(from_source, time);
    TransformStamped out;
    out.header.frame_id = target, out.child_frame_id = source;
    out.header.stamp = rclcpp::Time(time.time_since_epoch().count(), RCL_ROS_TIME);
    out.transform = toMsg(whole);
    return out;
  }
  /// The newest time that all moving frames of both paths have; 0 if none moves.
  TimePoint newest(const std::vector<std::string>& a, const std::vector<std::string>& b) const {
    std::optional<TimePoint> out;
    for (const auto* path : {&a, &b})
      for (const std::string& name : *path) {
        const Frame& frame = frames_.at(name);
        if (!frame.fixed && (!out || frame.samples.back().time < *out)) out = frame.samples.back().time;
      }
    return out.value_or(TimePoint());
  }
  Transform pose_in_common(const std::vector<std::string>& path, TimePoint time) const {
    Transform out;
    for (const std::string& name : path) out = at_time(name, frames_.at(name), time) * out;
    return out;
  }
  static Transform at_time(const std::string& name, const Frame& frame, TimePoint time) {
    const auto& all = frame.samples;
    if (frame.fixed) return Transform(all.front().rotation, all.front().origin);
    if (time < all.front().time || time > all.back().time)
      throw ExtrapolationException("Lookup would require extrapolation into the " +
                                   std::string(time < all.front().time ? "past" : "future") + ": time " +
                                   displayTimePoint(time) + " is asked for, '" + name + "' has " +
                                   displayTimePoint(all.front().time) + " to " +
                                   displayTimePoint(all.back().time));
    const auto next = std::lower_bound(all.begin(), all.end(), time,
                                       [](const Sample& sample, TimePoint at) { return sample.time < at; });
    if (next->time == time) return Transform(next->rotation, next->origin);
    const auto before = std::prev(next);
    const double part = durationToSec(time - before->time) / durationToSec(next->time - before->time);
    return Transform(before->rotation.slerp(next->rotation, part).normalized(),
                     before->origin * (1 - part) + next->origin * part);
  }

  const Duration cache_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::map<std::string, Frame> frames_;
  std::vector<std::weak_ptr<std::function<void()>>> listeners_;
};

}  // namespace tf2
