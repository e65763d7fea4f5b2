# The messages library. A generator program, which the build compiles first, makes most of it from
# interfaces.list.
find_package(OpenSSL REQUIRED)
set(messages ${PROJECT_SOURCE_DIR}/polyarm/messages)
set(made ${PROJECT_BINARY_DIR}/generated/polyarm/messages)
file(MAKE_DIRECTORY ${made})

add_library(polyarm_message_model STATIC ${messages}/generator/model.cpp)
target_include_directories(polyarm_message_model PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(polyarm_message_model PRIVATE OpenSSL::Crypto)
add_executable(polyarm_message_generator ${messages}/generator/main.cpp)
target_link_libraries(polyarm_message_generator PRIVATE polyarm_message_model)
if(CMAKE_BUILD_TYPE STREQUAL "Release")  # it only reads one list, once per build
  target_compile_options(polyarm_message_model PRIVATE -O0)
  target_compile_options(polyarm_message_generator PRIVATE -O0)
endif()
add_custom_command(OUTPUT ${made}/types.hpp ${made}/types.cpp
  COMMAND polyarm_message_generator ${messages}/interfaces.list ${made}
  DEPENDS polyarm_message_generator ${messages}/interfaces.list COMMENT "Making the messages of interfaces.list")

polyarm_room(messages USES base LIBRARIES nlohmann_json::nlohmann_json)
target_sources(polyarm_messages PRIVATE ${made}/types.cpp)
target_include_directories(polyarm_messages PUBLIC ${PROJECT_BINARY_DIR}/generated)
set_source_files_properties(${made}/types.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
