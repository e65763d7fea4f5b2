#pragma once
/// Why a request of a MoveIt client is not carried out.
#include <stdexcept>
#include <string>

#include "polyarm/messages/types.hpp"

namespace polyarm::move_group {

namespace msg = messages::moveit_msgs::msg;
namespace srv = messages::moveit_msgs::srv;
using Code = msg::MoveItErrorCodes;

/// `code`: one of Code. `what()`: one sentence with names and numbers.
class Refusal : public std::runtime_error {
 public:
  Refusal(int why, const std::string& what) : std::runtime_error(what), code(why) {}
  int code;
};

inline Code code_of(const Refusal& refusal) {
  return {refusal.code, refusal.what(), "polyarm"};
}
inline Code success() {
  return {Code::SUCCESS, "", "polyarm"};
}

}  // namespace polyarm::move_group
