#include "age.hpp"

static_assert(std::is_invocable_v<two_joints::Age::Told, std::array<double, 2>>);
