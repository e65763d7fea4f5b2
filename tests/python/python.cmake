# The Python module, with the Python that it is built for.
if(TARGET polyarm_python AND TARGET polyarm_driver_mujoco)
  set(home ${CMAKE_BINARY_DIR}/home_of_tests)  # of the tests and of what they start
  execute_process(COMMAND ${CMAKE_COMMAND} -E env HOME=${home} ${POLYARM_PYTHON} -c "import numpy" RESULT_VARIABLE no_numpy
                  OUTPUT_QUIET ERROR_QUIET)
  if(no_numpy)
    message(STATUS "NumPy not found (apt install python3-numpy): the Python module is not tested")
  else()
    file(MAKE_DIRECTORY ${home})
    foreach(name kinematics motion surroundings cell client page episodes policy teleop)
      add_test(NAME python.${name} COMMAND ${POLYARM_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/python/${name}_test.py)
      set_tests_properties(python.${name} PROPERTIES LABELS python TIMEOUT 300 ENVIRONMENT
        "HOME=${home};XDG_DATA_HOME=${home}/data;PYTHONPATH=${CMAKE_BINARY_DIR}/python:${CMAKE_CURRENT_SOURCE_DIR}/python;PYTHONDONTWRITEBYTECODE=1;POLYARM_COMMAND=$<TARGET_FILE:polyarm>;POLYARM_SOURCE=${PROJECT_SOURCE_DIR}")
    endforeach()
  endif()
endif()
