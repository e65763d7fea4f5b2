#pragma once
/// The name of Galactic.
#include "mock_components/generic_system.hpp"

namespace fake_components = mock_components;
