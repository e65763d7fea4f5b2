# What makes a fault in memory end a process instead of serving an attacker: the stack's guard, checked calls of the C
# library, a stack that cannot jump over its end, and tables of addresses that are read-only once the program is loaded.
# Rooms that only calculate, on numbers and not on foreign bytes, leave the guard and its nanoseconds out.
set(POLYARM_HARDENED FALSE)
set(POLYARM_RECKONING_ROOMS simd kinematics closed_form descent ik collision planning surroundings paths trajectory timing)
set(POLYARM_RECKONING_OPTIONS "")
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT POLYARM_SANITIZE AND CMAKE_SYSTEM_NAME STREQUAL "Linux")
  set(POLYARM_HARDENED TRUE)
  add_compile_options(-fstack-protector-strong -fstack-clash-protection -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
  add_link_options(-Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack)
  set(POLYARM_RECKONING_OPTIONS -fno-stack-protector -fno-stack-clash-protection)
endif()
