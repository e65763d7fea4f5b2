# Builds packages of ROS 2 without ROS. `polyarm plugin build` writes a CMakeLists.txt that includes this file, names
# the packages in the order of their dependencies, and ends with polyarm_ros_module.
#
# Set before: POLYARM_ROS_KIT (this folder's parent), POLYARM_ROS_HEADERS (Polyarm's own), POLYARM_ROS_GENERATED
# (structs of messages), POLYARM_ROS_MESSAGES (their packages), POLYARM_ROS_COMMAND (the command), and what
# wrappers.cmake needs.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
if(NOT CMAKE_CXX_STANDARD)
  set(CMAKE_CXX_STANDARD 17)
endif()
set(BUILD_TESTING OFF CACHE BOOL "tests of packages are not built" FORCE)
set(ENV{ROS_DISTRO} jazzy)
find_package(Threads REQUIRED)

add_library(polyarm_ros INTERFACE)
target_include_directories(polyarm_ros SYSTEM INTERFACE ${POLYARM_ROS_KIT}/include ${POLYARM_ROS_GENERATED})
# The headers use a few of Polyarm's. These come last, so that no package finds a file there that it means elsewhere.
target_compile_options(polyarm_ros INTERFACE "SHELL:-idirafter \"${POLYARM_ROS_HEADERS}\"")
# ROS installs the headers of a package below its name, and has both folders on the path: "angles/angles/angles.h" is
# "angles/angles.h", too.
set(polyarm_ros_nested_ ${CMAKE_BINARY_DIR}/nested)
file(MAKE_DIRECTORY ${polyarm_ros_nested_})
foreach(polyarm_ros_from_ ${POLYARM_ROS_KIT}/include ${POLYARM_ROS_GENERATED})
  file(GLOB polyarm_ros_folders_ LIST_DIRECTORIES TRUE RELATIVE ${polyarm_ros_from_} ${polyarm_ros_from_}/*)
  foreach(polyarm_ros_each_ ${polyarm_ros_folders_})
    file(CREATE_LINK ${polyarm_ros_from_} ${polyarm_ros_nested_}/${polyarm_ros_each_} SYMBOLIC)
  endforeach()
endforeach()
target_compile_options(polyarm_ros INTERFACE "SHELL:-idirafter \"${polyarm_ros_nested_}\"")
# Headers that packages install from elsewhere than their folder `include` (install() in targets.cmake).
set(POLYARM_ROS_STAGED ${CMAKE_BINARY_DIR}/staged)
file(MAKE_DIRECTORY ${POLYARM_ROS_STAGED}/include)
target_compile_options(polyarm_ros INTERFACE "SHELL:-idirafter \"${POLYARM_ROS_STAGED}/include\"")
# Packages of ROS get Eigen's folder by way of others, and name it nowhere.
find_package(Eigen3 QUIET NO_MODULE)
if(TARGET Eigen3::Eigen)
  get_target_property(polyarm_ros_eigen_ Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  target_include_directories(polyarm_ros SYSTEM INTERFACE ${polyarm_ros_eigen_})
endif()
target_compile_features(polyarm_ros INTERFACE cxx_std_17)
target_link_libraries(polyarm_ros INTERFACE Threads::Threads)

include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/targets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/ament.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/wrappers.cmake)

# In ROS a package also finds those that others need, so build files use versions of packages that they do not name.
file(STRINGS ${POLYARM_ROS_KIT}/packages.list polyarm_ros_rows_ REGEX "^[a-z0-9_]+ headers")
foreach(polyarm_ros_row_ ${polyarm_ros_rows_})
  string(REGEX REPLACE " .*" "" polyarm_ros_row_ "${polyarm_ros_row_}")
  polyarm_ros_versions(${polyarm_ros_row_})
endforeach()

# A package may set policies of a newer CMake than this one; mostly it does not need them. From then on, what modules of
# CMake set for themselves holds for the package too, because a macro can begin no block of policies.
function(polyarm_ros_new_policies folder)
  file(STRINGS ${folder}/CMakeLists.txt lines REGEX "^[ \t]*cmake_policy[ \t]*\\([ \t]*SET[ \t]+CMP[0-9]+")
  foreach(line ${lines})
    string(REGEX REPLACE ".*SET[ \t]+(CMP[0-9]+).*" "\\1" policy "${line}")
    if(NOT POLICY ${policy} AND NOT COMMAND _cmake_policy)
      macro(cmake_policy polyarm_ros_policy_)
        if("${polyarm_ros_policy_}" STREQUAL "SET")
          if(POLICY ${ARGV1})
            _cmake_policy(SET ${ARGN})
          endif()
        elseif(NOT "${polyarm_ros_policy_}" MATCHES "^(PUSH|POP)$")
          _cmake_policy(${polyarm_ros_policy_} ${ARGN})
        endif()
      endmacro()
    endif()
  endforeach()
endfunction()

# polyarm_ros_package(NAME FOLDER): builds a package of the workspace.
function(polyarm_ros_package name folder)
  set(CMAKE_CXX_STANDARD 17)
  polyarm_ros_new_policies(${folder})
  add_subdirectory(${folder} ${CMAKE_BINARY_DIR}/${name} EXCLUDE_FROM_ALL)
  set_property(GLOBAL PROPERTY POLYARM_ROS_FOLDER_${name} ${folder})
endfunction()

# With all of their classes, also those that nothing names.
function(polyarm_ros_link_whole)
  foreach(library ${ARGN})
    get_target_property(type ${library} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      target_link_libraries(polyarm_ros_plugin PRIVATE -Wl,--whole-archive $<TARGET_FILE:${library}> -Wl,--no-whole-archive)
      add_dependencies(polyarm_ros_plugin ${library})
    endif()
    target_link_libraries(polyarm_ros_plugin PRIVATE ${library})
  endforeach()
endfunction()
# polyarm_ros_whole(PACKAGE): its filters or kinematics, which the module's classes load by name.
function(polyarm_ros_whole package)
  get_property(all GLOBAL PROPERTY POLYARM_ROS_LIBRARIES_${package})
  polyarm_ros_link_whole(${all})
endfunction()

# polyarm_ros_module(PACKAGE OUT MAIN LIBRARIES…): links what the package's plugin descriptions name into one module.
function(polyarm_ros_module package out main)
  get_property(all GLOBAL PROPERTY POLYARM_ROS_LIBRARIES_${package})
  set(libraries "")
  foreach(library ${ARGN})
    if(library IN_LIST all)
      list(APPEND libraries ${library})
    endif()
  endforeach()
  if(NOT libraries)
    set(libraries ${all})
  endif()
  _add_library(polyarm_ros_plugin MODULE ${main})
  set_target_properties(polyarm_ros_plugin PROPERTIES PREFIX "" OUTPUT_NAME ${out} CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON)
  target_include_directories(polyarm_ros_plugin SYSTEM PRIVATE ${POLYARM_ROS_HEADERS})
  target_link_libraries(polyarm_ros_plugin PRIVATE polyarm_ros)
  polyarm_ros_link_whole(${libraries})
  # Plugin libraries of one package may be made of the same source files: the first definition counts.
  target_link_options(polyarm_ros_plugin PRIVATE -Wl,-z,muldefs)
  target_link_options(polyarm_ros_plugin PRIVATE -Wl,--version-script=${POLYARM_ROS_KIT}/cmake/module.map)
endfunction()
