#pragma once
/// The parts of a cell that never change while it runs, as the JSON from which the page draws the cell.
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"

namespace polyarm::server {

using Json = nlohmann::json;

/// {p: [x, y, z], q: [x, y, z, w]}; m.
Json pose_json(const Pose& pose);
/// {shape, size | radius, length, origin, mesh, scale}; m. A mesh whose file was not found is null.
Json shape_json(const description::Shape& shape);

/// /api/cell
Json cell_json(cell::CellView& cell);
/// /api/model/<robot>
Json model_json(const cell::CellRobot& robot);
/// /api/scene
Json scene_json(const cell::CellView& cell);
/// /api/requests
Json requests_json();

/// The models behind the GLB files that the models and the scene refer to. The key is the address
/// ("/api/mesh/<hash>.glb"); the value is a robot, or a robot with one link for a single mesh.
std::map<std::string, description::RobotModel> meshes_of(const cell::CellView& cell);

/// The same for the generated looks of grippers.
std::map<std::string, description::Tool> grippers_of(const cell::CellView& cell);

std::string dump(const Json& json);

}  // namespace polyarm::server
