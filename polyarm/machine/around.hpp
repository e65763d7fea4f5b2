#pragma once
/// What is around the robots of a cell, for moves that go around obstacles.
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "polyarm/moves/obstacles.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::cell {

/// The bodies of a cell, made when somebody needs them: that reads the disk. Any thread.
class SharedBodies {
 public:
  /// `robots` and `scene` outlive it.
  SharedBodies(const CellRobots& robots, const description::Scene& scene) : robots_(robots), scene_(scene) {}
  /// Throws Error as contact_bodies() does; then it tries again at the next call.
  std::shared_ptr<const ContactBodies> get();
  /// The same without the objects of clients.
  std::shared_ptr<const ContactBodies> own();
  /// Objects that clients add while the cell runs. They count from the next get() on.
  void set_objects(std::vector<description::Fixture> objects);
  /// Counts the calls of set_objects().
  std::uint64_t version() const { return version_.load(std::memory_order_acquire); }

 private:
  const std::shared_ptr<const ContactBodies>& made();
  const CellRobots& robots_;
  const description::Scene& scene_;
  std::mutex mutex_;
  std::shared_ptr<const ContactBodies> made_;
  std::shared_ptr<const ContactBodies> with_objects_;  // null: not made since the last change
  std::vector<description::Fixture> objects_;
  std::atomic<std::uint64_t> version_{0};
};

struct AroundOptions {
  double clearance = 0;  ///< m; less where start or goal are nearer to something
  /// True ends a search; null: it ends after a number of samples alone, so that a run repeats itself.
  std::function<bool()> stop;
};

/// Obstacles of robot `own` at a moment. A search has a fixed seed.
std::shared_ptr<moves::Obstacles> obstacles_around(std::shared_ptr<SharedBodies> bodies,
                                                   surroundings::Moment moment, std::size_t own,
                                                   AroundOptions options);

}  // namespace polyarm::cell
