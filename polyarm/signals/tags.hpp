#pragma once
/// The content of signals.yaml: tags and their interfaces, live data sets, cameras, links. Example:
///
///   polyarm: signals/1
///   tags:
///     Vacuum: {command: arm/tool/vacuum}            # output; type: bool (0 or 1) unless type: number
///     PartHeld: {state: arm/tool/part_present}      # input
///     Speed: {command: belt/speed, type: number, scale: 0.5, initial: 1}
///     Count: {initial: 3}                           # a value of the cell
///   live: [cycledata]                             # or data: {cycledata: {live: true}}
///   cameras:
///     bin_camera: {camera: overhead, point: pinput, data: BINpoints, request: AskPickupPoint,
///                  done: PickupPointSet, noise: true, seed: 7}
///   links:        # see links_file.hpp
///   heartbeat: {tag: CellAlive, every: 500ms}     # toggles only while control loop and cell thread live
///   watch: {PlcAlive: 2s}                         # if the tag does not change for this time, the cell holds
///   points: {pinput: {within: [[0.1, -0.2, 0], [0.5, 0.4, 0.3]]}}   # permitted poses from outside
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

/// The value of an output in a special situation; empty: it keeps its value.
struct OutputRules {
  std::optional<data::Value> on_stop;       ///< the program has ended, for any reason, and the robots are at
                                            ///< standstill
  std::optional<data::Value> on_hold;       ///< the cell is held or in a fault
  std::optional<data::Value> on_link_loss;  ///< a link that the cell needs is lost
  bool any() const { return on_stop || on_hold || on_link_loss; }
};
/// The cell's present situation, for the rules of outputs.
struct Situation {
  bool stopped = false, held = false, link_lost = false;
  friend bool operator==(const Situation&, const Situation&) = default;
};

/// A name in the cell, and its interface if it is bound to one.
struct Tag {
  enum class Type { boolean, number, text };
  std::string name;
  data::TagRole role = data::TagRole::plain;
  std::string interface;  ///< full name of the command or state interface; empty for a plain tag
  Type type = Type::boolean;
  double scale = 1;  ///< for numbers: interface = scale * tag
  data::Value initial = false;
  std::string unit;  ///< for display
  OutputRules rules;
  Location where;

  /// The value to send for the tag: `value`, or that of a rule.
  const data::Value& output(const data::Value& value, const Situation& now) const;
  /// The interface's value for a value of the tag; empty if the value has another type.
  std::optional<double> to_interface(const data::Value& value) const;
  /// The tag's value for a value of the interface; a boolean is True from 0.5 up.
  data::Value from_interface(double value) const;
};

/// A simulated camera. When the request tag is set, it writes the pose of the nearest part to a point.
struct CameraLink {
  std::string name;
  std::string camera;  ///< name in the scene
  std::string point;
  std::optional<std::string> data;  ///< the data set of the point; empty: any
  std::string request, done;        ///< tags
  bool noise = false;
  std::uint64_t seed = 1;
  std::string on;      ///< the robot whose flange carries it; empty: fixed, as in the scene
  Pose mount;          ///< T_tool0_camera for a carried camera; z is the viewing direction
  double view = 0.6;   ///< half of the viewing angle, rad
  double reach = 0.6;  ///< viewing distance, m
  Location where;
};

/// A tag that changes repeatedly while its owner is alive.
struct Heartbeat {
  std::string tag;
  Nanoseconds period = 500'000'000;  ///< own: period of its changes; watched: longest time without a change
  Location where;
};

struct Signals {
  std::vector<Tag> tags;
  std::vector<std::string> live;  ///< data sets, without file extension
  std::map<std::string, Location> live_where;
  std::vector<CameraLink> cameras;
  std::vector<LinkEntry> links;
  std::optional<Heartbeat> heartbeat;
  std::vector<Heartbeat> watched;
  std::map<std::string, PoseRange> points;  ///< permitted poses from outside, by point
};

/// Reads signals.yaml; mistakes go to `problems`.
Signals parse_signals(const std::string& text, const std::string& file, Problems& problems);
/// Throws Error with all problems of the file.
Signals load_signals(const std::string& path);

}  // namespace polyarm::signals
