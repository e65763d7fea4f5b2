# cmake -DPAGE=FOLDER -DOUT=FOLDER -DNODE=node -P embed_help.cmake: builds the documentation as a site and writes
# OUT/embedded_help.cpp, which carries it below /help/. Without the page's packages (PAGE may be empty) there is no help.
include(${CMAKE_CURRENT_LIST_DIR}/embed_files.cmake)
set(site "")
if(PAGE AND EXISTS ${PAGE}/node_modules/markdown-it)
  execute_process(COMMAND ${NODE} ${PAGE}/help/build.mjs ${OUT}/help RESULT_VARIABLE failed OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(failed)
    message(STATUS "${out}")
    message(WARNING "the pendant has no help: the documentation could not be built")
  else()
    set(site ${OUT}/help)
  endif()
endif()
embed_files("${site}" ${OUT} embedded_help embedded_help "/help/")
