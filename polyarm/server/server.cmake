# The pendant's server. Boost.Beast and Asio are header-only; only port.cpp includes them.
find_path(POLYARM_BEAST boost/beast/websocket.hpp)
if(NOT POLYARM_BEAST)
  message(FATAL_ERROR "Boost.Beast is missing: install libboost-dev, or run tools/setup")
endif()
find_package(OpenSSL REQUIRED)  # libssl-dev
polyarm_room(access USES base realtime protocol users LIBRARIES OpenSSL::SSL OpenSSL::Crypto)
polyarm_room(server USES base realtime description meshes shapes kinematics protocol users access io setup machine operation inside cell recording)
find_package(ZLIB REQUIRED)  # zlib1g-dev
target_link_libraries(polyarm_server PRIVATE OpenSSL::SSL OpenSSL::Crypto ZLIB::ZLIB)
target_include_directories(polyarm_server SYSTEM PRIVATE ${POLYARM_BEAST})
target_link_libraries(polyarm_server PRIVATE ${POLYARM_ZIP_LIBRARY})  # back up and restore a project
set_source_files_properties(server/port.cpp PROPERTIES COMPILE_OPTIONS "-O1")  # it mostly waits for sockets
# The cells of a site: a client of their ports, and a page of all.
polyarm_room(fleet USES base yaml access server LIBRARIES nlohmann_json::nlohmann_json fmt::fmt OpenSSL::SSL OpenSSL::Crypto)
target_include_directories(polyarm_fleet SYSTEM PRIVATE ${POLYARM_BEAST})
set_source_files_properties(fleet/cell_client.cpp PROPERTIES COMPILE_OPTIONS "-O1")

# npm builds the page from pendant/ when a file there has changed; it is compiled into the library. Without npm, Node.js 18
# or newer, or a network for the first build, the server shows a note instead of the page.
set(page ${PROJECT_SOURCE_DIR}/pendant)
set(built ${CMAKE_BINARY_DIR}/pendant)
set(steps ${PROJECT_SOURCE_DIR}/cmake/embed_page.cmake)
set(page_made "")
set(page_folder "")
find_program(NPM npm)
find_program(NODE NAMES node nodejs)
if(EXISTS ${page}/package-lock.json AND NPM AND NODE)
  execute_process(COMMAND ${NODE} -p "parseInt(process.versions.node)" OUTPUT_VARIABLE node_major ERROR_QUIET
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(node_major GREATER_EQUAL 18)
    file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS ${page}/src/* ${page}/public/*)
    file(GLOB page_settings CONFIGURE_DEPENDS ${page}/*.json ${page}/*.ts ${page}/*.js ${page}/*.mjs ${page}/*.html)
    set(page_made ${page_sources} ${page_settings})
    set(page_folder ${page})
  else()
    message(STATUS "Node.js ${node_major} is older than 18: the pendant has no page")
  endif()
elseif(EXISTS ${page}/package-lock.json)
  message(STATUS "npm is missing: the pendant has no page")
endif()
set(embedding ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake)
add_custom_command(
  OUTPUT ${built}/embedded_page.cpp
  COMMAND ${CMAKE_COMMAND} -DPAGE=${page_folder} -DOUT=${built} -DNPM=${NPM} -P ${steps}
  DEPENDS ${page_made} ${steps} ${embedding}
  COMMENT "The pendant's page"
  VERBATIM)
# The documentation is the pendant's help. It is built with packages that the page's build installs.
set(help_steps ${PROJECT_SOURCE_DIR}/cmake/embed_help.cmake)
file(GLOB help_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/* ${PROJECT_SOURCE_DIR}/docs/decisions/*.md
     ${PROJECT_SOURCE_DIR}/bench/journal/*.md ${page}/help/*)
list(FILTER help_sources EXCLUDE REGEX "/decisions$")
add_custom_command(
  OUTPUT ${built}/embedded_help.cpp
  COMMAND ${CMAKE_COMMAND} -DPAGE=${page_folder} -DOUT=${built} -DNODE=${NODE} -P ${help_steps}
  DEPENDS ${help_sources} ${PROJECT_SOURCE_DIR}/ARCHITECTURE.md ${PROJECT_SOURCE_DIR}/examples/README.md ${help_steps}
          ${embedding} ${built}/embedded_page.cpp
  COMMENT "The pendant's help"
  VERBATIM)
foreach(embedded embedded_page embedded_help)
  target_sources(polyarm_server PRIVATE ${built}/${embedded}.cpp)
  set_source_files_properties(${built}/${embedded}.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
endforeach()
