#pragma once
/// What the parts of the move_group door share: threads for long work, the planning scene, and messages as
/// structs.
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/io/worker.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/move_group/plans.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

/// Reads a payload of the type as the distribution has it.
template <class Message>
bool decode(const Bridge& bridge, std::span<const std::byte> payload, Message& out) {
  const messages::TypeInfo& own = messages::type_info<Message>();
  const messages::TypeInfo& theirs = bridge.type(own.name);
  if (&own == &theirs) return messages::from_cdr(payload, out) == messages::CdrError::none;
  Json fields;
  return messages::to_json(theirs, payload, fields) == messages::CdrError::none &&
         messages::from_cdr(messages::from_json(own, fields), out) == messages::CdrError::none;
}
template <class Message>
Json json_of(const Message& message) {
  Json out;
  messages::to_json(messages::type_info<Message>(), messages::to_cdr(message), out);
  return out;
}
template <class Message>
std::vector<std::byte> encode(const Bridge& bridge, const Message& message) {
  const messages::TypeInfo& own = messages::type_info<Message>();
  const messages::TypeInfo& theirs = bridge.type(own.name);
  return &own == &theirs ? messages::to_cdr(message) : messages::from_json(theirs, json_of(message));
}

/// Runs long work on threads of its own and its ends on the cell thread. Cell thread, except where noted.
class LongWork {
 public:
  /// Called on the cell thread when the work is done.
  using Then = std::function<void()>;
  /// Called on another thread.
  using Work = std::function<Then()>;
  static constexpr std::size_t kMostWaiting = 64;

  explicit LongWork(bool run_inline)
      : ended_{std::make_shared<Ended>()}, queries_{run_inline}, plans_{run_inline} {}

  /// Queries take milliseconds, plans seconds: neither waits for the other. False if too much waits already.
  bool query(Work work) { return post(queries_, ended_->queries, std::move(work)); }
  bool plan(Work work) { return post(plans_, ended_->plans, std::move(work)); }
  /// Call each tick.
  void finish();

 private:
  struct Ended {
    std::mutex mutex;
    std::deque<Then> thens;
    std::atomic<std::size_t> queries{0}, plans{0};
  };
  bool post(cell::Worker& worker, std::atomic<std::size_t>& waiting, Work work);

  std::shared_ptr<Ended> ended_;
  cell::Worker queries_, plans_;
};

/// The planning scene of the cell: all robots share it. Any thread.
class SharedScene {
 public:
  std::shared_ptr<const move_group::SceneState> now() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  void set(move_group::SceneState state) {
    auto next = std::make_shared<const move_group::SceneState>(std::move(state));
    const std::lock_guard lock(mutex_);
    now_.swap(next);
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const move_group::SceneState> now_ = std::make_shared<const move_group::SceneState>();
};

/// What the nodes of all robots share.
struct MoveGroupCell {
  explicit MoveGroupCell(Bridge& to) : bridge{to}, bodies{to.cell().bodies()}, work{to.cell().lock_step()} {}

  Bridge& bridge;
  std::shared_ptr<SharedScene> scene = std::make_shared<SharedScene>();
  std::shared_ptr<cell::SharedBodies> bodies;
  LongWork work;
  std::uint64_t guarded = 0;  ///< version of the scene that the guards know
  /// Call each tick: guards keep robots, and the objects that they hold, off the objects of clients.
  void tell_guards() {
    const auto now = scene->now();
    if (std::exchange(guarded, now->version) != now->version)
      bridge.cell().set_more_obstacles(move_group::fixtures_of(*now), move_group::attached_of(*now));
  }
  /// Set when the door closes: work that is under way ends early.
  std::shared_ptr<std::atomic<bool>> closing = std::make_shared<std::atomic<bool>>(false);

  /// Makes the present moment, on the cell thread. Call the function on another thread: it may read the disk.
  using Look = std::function<move_group::Around()>;
  Look look(std::shared_ptr<const move_group::Arm> arm) const;
  move_group::PlanSettings settings(std::shared_ptr<std::atomic<bool>> cancelled = nullptr) const;
  /// Reports a sentence on /rosout and in the terminal.
  void tell(const std::string& text) const { bridge.cell().tell("ROS 2: move_group: " + text); }
};

/// The actions move_action and execute_trajectory of one robot.
class MoveGroupMotion {
 public:
  /// `space`: the prefix of names, "" or "/left".
  MoveGroupMotion(MoveGroupCell& shared, std::shared_ptr<const move_group::Arm> arm, std::string node,
                  const std::string& space);
  ~MoveGroupMotion();
  /// Call each tick.
  void serve();

 private:
  struct Work;
  std::shared_ptr<Work> work_;
};

}  // namespace polyarm::ros2
