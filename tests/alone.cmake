# Tests whose loop runs on the wall clock against another process: a loop that is late by much is a fault for the
# controller on the far side. Nothing runs beside them.
set_tests_properties(ur.UrExample.ACellInAnotherProcessIsArmedAndPlaces fanuc.FanucExample.ACellInAnotherProcessIsArmedAndPlaces
                     PROPERTIES RUN_SERIAL TRUE)
