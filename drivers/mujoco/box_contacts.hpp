#pragma once
/// Contacts between two boxes without those that do not exist. SI units.
///
/// If a face of one box is exactly parallel to a face of the other, such as a part that lies flat on a belt
/// or on a table, MuJoCo 2.2 sometimes adds points far beside the boxes, up to metres deep. One such point
/// throws the part away within one step. Up to a quarter of all turned, flat poses are hit; a tilt of
/// 1e-12 rad suffices to be spared.

namespace polyarm::drivers {

/// From now on MuJoCo's contacts between boxes are only those whose point lies at both boxes and which are no
/// deeper than the boxes overlap. For the whole process; further calls have no effect. Before the first
/// simulation.
void keep_true_box_contacts() noexcept;

}  // namespace polyarm::drivers
