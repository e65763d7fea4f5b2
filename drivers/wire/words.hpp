#pragma once
/// Sentences for what ends the link of every driver of a robot controller. `where` is "the controller at
/// ADDRESS". Any thread.
#include <string>

namespace polyarm::wire {

/// "the controller at 192.168.1.10" → "192.168.1.10"
std::string address_in(const std::string& where);
/// A command that the shaper could not follow. `detail`: 3 × joint from 0, plus the limit (Shaper::exceeded).
/// Ends with what to change in the cell; the driver may add more.
std::string too_fast_sentence(int detail, const std::string& where);
std::string loop_silent_sentence(const std::string& where);
/// `joint` counts from 0.
std::string jump_sentence(int joint, const std::string& where);
/// In forward mode a controller of the cell commands the joint, which counts from 0.
std::string joint_commands_sentence(int joint, const std::string& where);

}  // namespace polyarm::wire
