#pragma once
/// What signals.yaml declares: tags and what they are bound to, data sets with a file of their own, cameras.
///
///   polyarm: signals/1
///   tags:
///     Vacuum: {command: arm/tool/vacuum}            # goes out; type: bool (0 or 1) unless it says number
///     PartHeld: {state: arm/tool/part_present}      # comes in
///     Speed: {command: belt/speed, type: number, scale: 0.5, initial: 1}
///     Count: {initial: 3}                           # a value of the cell
///   live: [cycledata]                             # or data: {cycledata: {live: true}}
///   cameras:
///     bin_camera: {camera: overhead, point: pinput, data: BINpoints, request: AskPickupPoint,
///                  done: PickupPointSet, noise: true, seed: 7}
///   links:        # see links_file.hpp
///   heartbeat: {tag: CellAlive, every: 500ms}     # toggles only while control loop and cell thread live
///   watch: {PlcAlive: 2s}                         # a tag that does not change for so long: the cell holds
///   points: {pinput: {within: [[0.1, -0.2, 0], [0.5, 0.4, 0.3]]}}   # what a pose from outside may be
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {

/// What an output has while the cell is not as usual; nothing: it keeps its value.
struct OutputRules {
  std::optional<data::Value> on_stop;       ///< the program has ended, for whatever reason, and all stands
  std::optional<data::Value> on_hold;       ///< the cell is held, or in a fault
  std::optional<data::Value> on_link_loss;  ///< a link that the cell needs is lost
  bool any() const { return on_stop || on_hold || on_link_loss; }
};
/// What holds of a cell now, for the rules of its outputs.
struct Situation {
  bool stopped = false, held = false, link_lost = false;
  friend bool operator==(const Situation&, const Situation&) = default;
};

/// A name of the cell, and the interface that it is bound to, if any.
struct Tag {
  enum class Type { boolean, number, text };
  std::string name;
  data::TagRole role = data::TagRole::plain;
  std::string interface;  ///< full name of the command or state interface; empty for a plain tag
  Type type = Type::boolean;
  double scale = 1;  ///< interface = scale * tag, for numbers
  data::Value initial = false;
  std::string unit;  ///< as it is shown
  OutputRules rules;
  Location where;

  /// The value that goes out for the tag's `value`: another one where a rule says so.
  const data::Value& output(const data::Value& value, const Situation& now) const;
  /// The interface's value for a value of the tag; nothing where the value is of another type.
  std::optional<double> to_interface(const data::Value& value) const;
  /// The tag's value for a value of the interface; a boolean is True from one half up.
  data::Value from_interface(double value) const;
};

/// A camera stand-in: asked by a tag, it writes the pose of the nearest part to a point.
struct CameraLink {
  std::string name;
  std::string camera;  ///< of the scene
  std::string point;
  std::optional<std::string> data;  ///< the data set that holds the point; nothing: wherever it is
  std::string request, done;        ///< tags
  bool noise = false;
  std::uint64_t seed = 1;
  std::string on;      ///< the robot whose flange carries it; empty: it stands where the scene has it
  Pose mount;          ///< T_tool0_camera of such a one, z the way it looks
  double view = 0.6;   ///< half of its angle of view, rad
  double reach = 0.6;  ///< how far it sees, m
  Location where;
};

/// A tag that shows that somebody lives: it changes again and again.
struct Heartbeat {
  std::string tag;
  Nanoseconds period = 500'000'000;  ///< own: of its changes; watched: the longest without one
  Location where;
};

struct Signals {
  std::vector<Tag> tags;
  std::vector<std::string> live;  ///< data sets, without the ending of their file
  std::map<std::string, Location> live_where;
  std::vector<CameraLink> cameras;
  std::vector<LinkEntry> links;
  std::optional<Heartbeat> heartbeat;
  std::vector<Heartbeat> watched;
  std::map<std::string, PoseRange> points;  ///< what poses from outside may be, by point
};

/// Reads signals.yaml; findings go to `problems`.
Signals parse_signals(const std::string& text, const std::string& file, Problems& problems);
/// Throws Error with every problem of the file.
Signals load_signals(const std::string& path);

}  // namespace polyarm::signals
