# The page, in Chromium where that is installed; skipped without npm.
add_test(NAME pendant COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/pendant/run $<TARGET_FILE:polyarm>)
set_tests_properties(pendant PROPERTIES LABELS pendant SKIP_RETURN_CODE 77 TIMEOUT 1800 RUN_SERIAL TRUE)
if(TARGET servos_bus_process)
  set_tests_properties(pendant PROPERTIES ENVIRONMENT "POLYARM_SERVOS=$<TARGET_FILE:servos_bus_process>")
endif()
