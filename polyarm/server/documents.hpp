#pragma once
/// What of a cell never changes while it runs, as the JSON that a page draws it from.
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

/// What is made into the GLBs that models and scene name, by the address they have there
/// ("/api/mesh/<hash>.glb"): robots, and robots of one link for meshes that stand alone.
std::map<std::string, description::RobotModel> meshes_of(const cell::CellView& cell);

std::string dump(const Json& json);

}  // namespace polyarm::server
