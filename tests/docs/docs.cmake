# The commands that the pages of docs/ and README.md show, with physics. Skipped without Python.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_Interpreter_FOUND AND TARGET polyarm_driver_mujoco)
  add_test(NAME docs COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/docs/run_commands $<TARGET_FILE:polyarm>)
  set_tests_properties(docs PROPERTIES LABELS docs TIMEOUT 300)
endif()
