# The Python module, with the Python that it is built for.
if(TARGET polyarm_python AND TARGET polyarm_driver_mujoco)
  execute_process(COMMAND ${POLYARM_PYTHON} -c "import numpy" RESULT_VARIABLE no_numpy OUTPUT_QUIET ERROR_QUIET)
  if(no_numpy)
    message(STATUS "NumPy not found (apt install python3-numpy): the Python module is not tested")
  else()
    file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/home_of_tests)  # of the programs that they start
    foreach(name kinematics motion surroundings cell client page episodes teleop)
      add_test(NAME python.${name} COMMAND ${POLYARM_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/python/${name}_test.py)
      set_tests_properties(python.${name} PROPERTIES LABELS python TIMEOUT 300 ENVIRONMENT
        "HOME=${CMAKE_BINARY_DIR}/home_of_tests;XDG_DATA_HOME=${CMAKE_BINARY_DIR}/home_of_tests/data;PYTHONPATH=${CMAKE_BINARY_DIR}/python:${CMAKE_CURRENT_SOURCE_DIR}/python;PYTHONDONTWRITEBYTECODE=1;POLYARM_COMMAND=$<TARGET_FILE:polyarm>;POLYARM_SOURCE=${PROJECT_SOURCE_DIR}")
    endforeach()
  endif()
endif()
