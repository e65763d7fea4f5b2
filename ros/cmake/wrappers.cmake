# The code that makes a component or a controller of Polyarm out of a class of ROS knows no package. So it is compiled
# once for all packages of this machine, and lies in a folder that they share, by the compiler, its flags and the content
# of the headers.
#
# Set before: POLYARM_ROS_SHARED (the folder), POLYARM_ROS_KEY (a hash of the headers).

# polyarm_ros_wrapper(NAME): compiles wrappers/NAME.cpp unless that was done before, and links it into the module.
function(polyarm_ros_wrapper name)
  string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
  separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${type}}")
  get_directory_property(definitions COMPILE_DEFINITIONS)  # POLYARM_ROS_FOXY
  foreach(each ${definitions})
    list(APPEND flags -D${each})
  endforeach()
  # A new release of the system's C library changes no header of ours.
  file(TIMESTAMP /usr/include/features.h system)
  string(SHA256 key "${POLYARM_ROS_KEY};${CMAKE_CXX_COMPILER};${CMAKE_CXX_COMPILER_VERSION};${flags};${system}")
  string(SUBSTRING ${key} 0 16 key)
  set(object ${POLYARM_ROS_SHARED}/${name}-${key}.o)
  if(NOT EXISTS ${object})
    polyarm_ros_forget_wrappers()
  endif()
  # Another build may compile it at the same time, so each build tree has a file of its own. Its name stays the same:
  # CMake removes the object, which others use too, when the command changes.
  string(SHA256 unique "${CMAKE_BINARY_DIR}")
  string(SUBSTRING ${unique} 0 8 unique)
  set(made ${POLYARM_ROS_SHARED}/${name}-${unique}.tmp)
  add_custom_command(OUTPUT ${object}
    COMMAND ${CMAKE_CXX_COMPILER} ${flags} -fPIC -std=gnu++20 -isystem ${POLYARM_ROS_KIT}/include
            -isystem ${POLYARM_ROS_GENERATED} -isystem ${POLYARM_ROS_HEADERS} -c ${POLYARM_ROS_KIT}/wrappers/${name}.cpp
            -o ${made}
    COMMAND ${CMAKE_COMMAND} -E rename ${made} ${object}
    COMMENT "Compiling ${name}.cpp for all packages" VERBATIM)
  set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
  target_sources(polyarm_ros_plugin PRIVATE ${object})
endfunction()

# Removes those of earlier releases, and what a killed build left. What is younger than an hour stays: another build may
# use it.
function(polyarm_ros_forget_wrappers)
  file(MAKE_DIRECTORY ${POLYARM_ROS_SHARED})
  file(GLOB all ${POLYARM_ROS_SHARED}/*.o ${POLYARM_ROS_SHARED}/*.tmp)
  list(LENGTH all count)
  if(NOT count GREATER 16)
    return()
  endif()
  string(TIMESTAMP now "%s" UTC)
  foreach(each ${all})
    file(TIMESTAMP ${each} made "%s" UTC)
    if(made AND now GREATER made)  # empty: another build has moved it
      math(EXPR age "${now} - ${made}")
      if(age GREATER 3600)
        file(REMOVE ${each})
      endif()
    endif()
  endforeach()
endfunction()
