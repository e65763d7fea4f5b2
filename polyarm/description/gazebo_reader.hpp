#pragma once
/// Reads `<gazebo>` elements of a description. Private to this room.
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/xml_reader.hpp"

namespace polyarm::description {

/// Reads friction, self-collision and damping; lists the other elements once. A value that cannot be read is
/// left out with a warning: these elements are for a simulator, and kinematics works without them.
class GazeboReader : private XmlReader {
 public:
  GazeboReader(const std::string& file, Problems& warnings) : XmlReader(file, faults_, warnings) {}

  /// Call it for each <gazebo>, before or after links and joints. The elements must live until finish().
  void add(const Element& e) { elements_.push_back(&e); }
  /// Writes the values to links and joints, and lists all ignored elements in one warning.
  void finish(RobotModel& model);

 private:
  void apply(const Element& e, RobotModel& model);
  static void controllers(const Element& plugin, RobotModel& model);
  bool whole_robot(const Element& e, RobotModel& model);
  bool link(const Element& e, Link& link);
  void gravity(const Element& e, const Link& link, bool off_by);
  bool joint(const Element& e, Joint& joint);
  std::optional<double> amount(const Element& e);
  std::optional<bool> choice(const Element& e);
  void pass_over(const Element& e);

  Problems faults_;  ///< values that cannot be read
  std::vector<const Element*> elements_;
  std::vector<std::string> passed_over_;  ///< "<plugin> (line 12)", the first element of each ignored tag
  std::vector<std::string> tags_;
  Location first_;
  std::vector<std::string> weightless_;  ///< links without gravity
  Location first_weightless_;
};

}  // namespace polyarm::description
