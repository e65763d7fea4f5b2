#include "polyarm/setup/cell_setup.hpp"

#include "polyarm/description/scene_file.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/setup/build.hpp"
#include "polyarm/setup/controllers_plan.hpp"
#include "polyarm/setup/floor.hpp"

namespace polyarm::cell {

ros_files::ControllersFile read_setup(CellSetup& setup, Observer& observer, Problems& problems) {
  std::vector<std::string> notes = setup.file.notes;
  if (setup.options.no_code)
    check_plugins_of_cell(setup.file, problems);
  else
    load_plugins(setup.file, problems);
  ros_files::ControllersFile described;
  collect(problems, [&] { described = read_cell_controllers(setup.file, problems); });
  setup.robots = resolve_robots(setup.file, described, setup.catalogue, setup.options.real, problems, notes);
  add_hardware_faults(setup.robots, Severity::error, problems);
  make_robot_bodies(setup.robots, problems);  // the floor is below them
  collect(problems, [&] {
    setup.scene = setup.file.scene.empty()
                      ? scene_without_file(setup.robots, notes)
                      : description::read_scene(
                            file_of_cell(setup.file, setup.file.scene, setup.file.scene_where), problems);
  });
  make_scene_bodies(setup.robots, setup.scene, problems);
  setup.unchecked_bodies = cell::unchecked_bodies(setup.robots, setup.scene);
  for (const auto& more :
       {sentences(setup.unchecked_bodies), physics_notes(setup.robots), notes_of_arms(setup.robots)})
    notes.insert(notes.end(), more.begin(), more.end());
  for (const std::string& note : notes) observer.on_note(note);
  problems.throw_if_errors();
  setup.manager = described.manager;
  return described;
}

}  // namespace polyarm::cell
