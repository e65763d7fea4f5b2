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
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_store.hpp"

namespace polyarm::signals {

/// A name of the cell, and the interface that it is bound to, if any.
struct Tag {
  enum class Type { boolean, number, text };
  std::string name;
  data::TagRole role = data::TagRole::plain;
  std::string interface;  ///< full name of the command or state interface; empty for a plain tag
  Type type = Type::boolean;
  double scale = 1;  ///< interface = scale * tag, for numbers
  data::Value initial = false;
  Location where;

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
  Location where;
};

struct Signals {
  std::vector<Tag> tags;
  std::vector<std::string> live;
  std::vector<CameraLink> cameras;
};

/// Reads signals.yaml; findings go to `problems`.
Signals parse_signals(const std::string& text, const std::string& file, Problems& problems);
/// Throws Error with every problem of the file.
Signals load_signals(const std::string& path);

}  // namespace polyarm::signals
