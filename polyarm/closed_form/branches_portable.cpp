// Closed forms compiled for every processor of the architecture.
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // in the header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "polyarm/closed_form/branch_kernels.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"
#define POLYARM_WIDTH 2
#define POLYARM_LANES polyarm::kinematics::lanes_portable
#include "polyarm/closed_form/branch_kernels.inc"
