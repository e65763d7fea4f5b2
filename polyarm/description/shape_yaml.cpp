#include "polyarm/description/shape_yaml.hpp"

#include <cmath>
#include <filesystem>
#include <string>
#include <system_error>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/clouds/cloud_file.hpp"

namespace polyarm::description {

const std::vector<std::string>& shape_keys() {
  static const std::vector<std::string> keys = {"box", "cylinder", "sphere", "capsule"};
  return keys;
}

namespace {
double positive(const Yaml& yaml) {
  const double value = yaml.number(Dimension::length);
  constexpr double kLargest = bounds::kSceneMetres;
  constexpr double kLong = 20;  // a size of this or more needs a unit
  if (!(value > 0 && value <= kLargest))
    throw Error(Problem{"bad-value",
                        yaml.where(),
                        "'" + yaml.text() + "' is not a size: it must be above zero and at most " +
                            std::to_string(bounds::kSceneMetres) + " m",
                        {}});
  const bool has_unit = yaml.text().find_first_not_of("+.0123456789eE") != std::string::npos;
  if (value >= kLong && !has_unit)
    throw Error(Problem{"bad-value", yaml.where(), "a size of " + yaml.text() + " m is unusual",
                        "this looks like millimetres, write " + yaml.text() + "mm, or " + yaml.text() +
                            "m: lengths without a unit are metres"});
  return value;
}
}  // namespace

Shape read_shape(const Yaml& yaml) {
  std::vector<std::string> said;
  for (const std::string& key : shape_keys())
    if (yaml.has(key)) said.push_back(key);
  if (said.size() != 1)
    throw Error(Problem{
        "missing-key", yaml.where(),
        said.empty() ? "no shape is given here" : "more than one shape is given here: " + join(said, ", "),
        "give one of: " + join(shape_keys(), ", ")});
  Shape out;
  const Yaml value = yaml[said.front()];
  if (said.front() == "box") {
    out.kind = ShapeKind::box;
    out.size = value.vec3();
    for (const Yaml& edge : value.items()) positive(edge);
  } else if (said.front() == "cylinder") {
    out.kind = ShapeKind::cylinder;
    out.radius = positive(value.required("radius"));
    out.length = positive(value.required("height"));
  } else if (said.front() == "sphere") {
    out.kind = ShapeKind::sphere;
    out.radius = positive(value.required("radius"));
  } else {
    out.kind = ShapeKind::capsule;
    out.radius = positive(value.required("radius"));
    out.length = positive(value.required("length"));
  }
  return out;
}

namespace {
double metres_in(const Yaml& unit) {
  const std::string text = unit.text("m");
  if (text == "m") return 1;
  if (text == "mm") return 1e-3;
  if (text == "cm") return 1e-2;
  if (text == "in") return 0.0254;
  throw Error(Problem{"bad-value", unit.where(),
                      "'" + shortened(text) + "' is not a unit of a file with a shape",
                      "write m, mm, cm or in"});
}
std::filesystem::path beside(const Yaml& yaml, const std::string& file) {
  return std::filesystem::path(yaml.where().file).parent_path() / file;
}
}  // namespace

Shape read_shape_or_mesh(const Yaml& yaml) {
  const Yaml mesh = yaml["mesh"];
  if (!mesh.defined()) return read_shape(yaml);
  for (const std::string& key : shape_keys())
    if (yaml.has(key))
      throw Error(Problem{"bad-value", yaml.where(), "'mesh' and '" + key + "' are given for one thing", "keep one of them"});
  Problems problems;
  if (mesh.is_map()) mesh.check_keys({"file", "unit", "scale"}, problems);
  problems.throw_if_errors();
  const Yaml file = mesh.is_map() ? mesh.required("file") : mesh;
  Shape out;
  out.kind = ShapeKind::mesh;
  out.mesh = file.text();
  const std::filesystem::path path = beside(yaml, out.mesh);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Error(Problem{"no-mesh", file.where(), "there is no mesh file " + path.string(),
                        "paths of meshes begin at the folder of this file"});
  out.mesh_path = path.string();
  const double metres = metres_in(mesh["unit"]);
  const Yaml scale = mesh["scale"];
  out.scale = scale.is_list() ? scale.vec3(Dimension::none)
                              : scale.number(Dimension::none, 1) * Vec3{1, 1, 1};
  for (const double each : {out.scale.x, out.scale.y, out.scale.z})
    if (!(each > 0 && each <= 1e6))
      throw Error(Problem{"bad-value", scale.where(), "the scale of a mesh must be above zero and at most 1e6", {}});
  out.scale = metres * out.scale;
  return out;
}

std::vector<Shape> read_cloud(const Yaml& yaml) {
  for (const char* key : {"mesh", "box", "cylinder", "sphere", "capsule"})
    if (yaml.has(key))
      throw Error(Problem{"bad-value", yaml.where(),
                          std::string("'cloud' and '") + key + "' are given for one thing",
                          "keep one of them"});
  const Yaml cloud = yaml["cloud"];
  Problems problems;
  if (cloud.is_map()) cloud.check_keys({"file", "unit", "radius", "cell"}, problems);
  problems.throw_if_errors();
  const Yaml file = cloud.is_map() ? cloud.required("file") : cloud;
  clouds::CloudOptions options;
  options.scale = metres_in(cloud["unit"]);
  if (cloud["radius"].defined()) options.radius = positive(cloud["radius"]);
  if (cloud["cell"].defined()) options.cell = positive(cloud["cell"]);
  clouds::Cloud read;
  try {
    read = clouds::read_cloud(beside(yaml, file.text()), options);
  } catch (const Error& e) {
    Problem problem = e.problems().front();
    problem.where = file.where();
    throw Error(std::move(problem));
  }
  const std::string note =
      file.text() + ": " + std::to_string(read.points) + " points in " + std::to_string(read.boxes.size()) +
      " boxes, cells of " + format_number(std::round(1e4 * read.cell) / 10) + " mm" +
      (read.dropped > 0 ? ", " + std::to_string(read.dropped) + " points without a place left out" : "");
  std::vector<Shape> out;
  for (const clouds::CloudBox& box : read.boxes) {
    Shape shape;
    shape.size = box.upper - box.lower;
    shape.pose.position = 0.5 * (box.lower + box.upper);
    shape.mesh = note;
    out.push_back(std::move(shape));
  }
  return out;
}

}  // namespace polyarm::description
