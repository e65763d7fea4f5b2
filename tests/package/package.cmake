# An installation that was moved away from the tree that it was built in. Skipped without Python.
if(Python3_Interpreter_FOUND AND TARGET polyarm_driver_mujoco)
  add_test(NAME package COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/package/installed ${CMAKE_COMMAND}
           ${CMAKE_BINARY_DIR} ${PROJECT_SOURCE_DIR} Installed)
  set_tests_properties(package PROPERTIES LABELS package TIMEOUT 300)
  add_test(NAME packages COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/package/installed ${CMAKE_COMMAND}
           ${CMAKE_BINARY_DIR} ${PROJECT_SOURCE_DIR} Packages)
  set_tests_properties(packages PROPERTIES LABELS package TIMEOUT 1200)  # a minute of processor time
endif()
add_test(NAME package.compiler_runs_again COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/package/compiler_runs_again ${PROJECT_SOURCE_DIR}/cmake/compile)
