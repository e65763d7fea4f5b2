# polyarm_host(TARGET): an executable that loads plugins. It carries the rooms that plugins know whole, used by
# itself or not, and exports their symbols, so that a plugin finds one definition of everything: the host's.
set(POLYARM_PLUGIN_ROOMS polyarm_base polyarm_description polyarm_trajectory polyarm_hardware polyarm_controllers)
function(polyarm_host target)
  set_target_properties(${target} PROPERTIES ENABLE_EXPORTS ON)
  target_link_options(${target} PRIVATE -Wl,--whole-archive)
  foreach(room ${POLYARM_PLUGIN_ROOMS})
    target_link_options(${target} PRIVATE $<TARGET_FILE:${room}>)
  endforeach()
  target_link_options(${target} PRIVATE -Wl,--no-whole-archive)
  add_dependencies(${target} ${POLYARM_PLUGIN_ROOMS})
endfunction()
