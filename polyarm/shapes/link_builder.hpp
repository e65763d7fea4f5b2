#pragma once
/// Builds the surfaces of one rigid body of a robot in a given style.
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/shapes/skeleton.hpp"
#include "polyarm/shapes/style.hpp"

namespace polyarm::shapes {

/// The position of a body in its arm: the number of moving joints from the base to the body, and to the arm's
/// tip.
struct Rank {
  int depth = 0, most = 0;
};

/// The paint of a body without its housings, rings and covers.
const Paint& paint_of(const Style& style, const Rank& rank);

/// `travel`: the range of the body's joint, rad or m; used only for sliding joints.
meshes::Mesh build_link(const RigidBody& body, const Style& style, const Rank& rank, double travel);

}  // namespace polyarm::shapes
