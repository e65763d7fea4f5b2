#pragma once
/// `<gazebo>` of a description, private to the room.
#include "polyarm/description/model_builder.hpp"
#include "polyarm/description/xml_reader.hpp"

namespace polyarm::description {

/// Friction, self-collision and damping; the rest is remembered to be listed once.
class GazeboReader : private XmlReader {
 public:
  GazeboReader(const std::string& file, Problems& problems, Problems& warnings)
      : XmlReader(file, problems, warnings) {}

  /// Called for each <gazebo>, in any order with links and joints. The elements have to live until finish().
  void add(const Element& e) { elements_.push_back(&e); }
  /// Writes what was read into the links and joints, and lists in one warning what is passed over.
  void finish(RobotModel& model);

 private:
  void apply(const Element& e, RobotModel& model);
  static void controllers(const Element& plugin, RobotModel& model);
  bool whole_robot(const Element& e, RobotModel& model);
  bool link(const Element& e, Link& link);
  bool joint(const Element& e, Joint& joint);
  std::optional<double> amount(const Element& e);
  void pass_over(const Element& e);

  std::vector<const Element*> elements_;
  std::vector<std::string> passed_over_;  ///< "<plugin> (line 12)", the first of each tag
  std::vector<std::string> tags_;
  Location first_;
};

}  // namespace polyarm::description
