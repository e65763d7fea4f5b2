# cmake -DPAGE=FOLDER -DOUT=FOLDER -DNPM=npm -P embed_page.cmake: builds the page with npm and writes OUT/embedded_page.cpp,
# which carries its files, compressed where that helps. PAGE may be empty: then there is no page.
file(MAKE_DIRECTORY ${OUT})
set(dist "")

# step(WHAT COMMAND…): says what failed, and goes on without a page.
function(step what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${PAGE} RESULT_VARIABLE failed OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(failed)
    string(LENGTH "${out}" length)
    if(length GREATER 3000)
      math(EXPR from "${length} - 3000")
      string(SUBSTRING "${out}" ${from} -1 out)
    endif()
    message(STATUS "${out}")
    message(WARNING "the pendant has no page: ${what} failed in ${PAGE}")
    set(good FALSE PARENT_SCOPE)
  endif()
endfunction()

if(PAGE)
  set(good TRUE)
  file(SHA256 ${PAGE}/package-lock.json lock)
  set(installed ${PAGE}/node_modules/.polyarm_installed)
  set(known "")
  if(EXISTS ${installed})
    file(READ ${installed} known)
  endif()
  if(NOT known STREQUAL lock)
    step("npm ci" ${NPM} ci --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000)
    if(good)
      file(WRITE ${installed} ${lock})
    endif()
  endif()
  if(good)
    step("npm run build" ${NPM} run --silent build)
  endif()
  if(good)
    set(dist ${PAGE}/dist)
  endif()
endif()

set(data "")
set(rows "")
if(dist)
  file(REMOVE_RECURSE ${OUT}/files)
  file(MAKE_DIRECTORY ${OUT}/files)
  file(GLOB_RECURSE files RELATIVE ${dist} ${dist}/*)
  set(n 0)
  foreach(file ${files})
    set(gzip false)
    set(stored ${OUT}/files/${n})
    if(file MATCHES "[.](html|js|css|json|svg|txt|webmanifest|wasm|ico)$")
      execute_process(COMMAND gzip -9 -n -c ${dist}/${file} OUTPUT_FILE ${stored} RESULT_VARIABLE failed)
      if(NOT failed)
        set(gzip true)
      endif()
    endif()
    if(NOT gzip)
      file(COPY_FILE ${dist}/${file} ${stored})
    endif()
    file(SHA256 ${stored} sum)  # so that this text changes with the file
    string(APPEND data "// ${file} ${sum}\n"
      "asm(\".section .rodata\\n.balign 16\\npolyarm_page_${n}:\\n.incbin \\\"${stored}\\\"\\npolyarm_page_${n}_end:\\n"
      ".byte 0\\n.previous\\n\");\n"
      "extern \"C\" const char polyarm_page_${n}[], polyarm_page_${n}_end[];\n")
    string(APPEND rows "    {\"/${file}\", {view(polyarm_page_${n}, polyarm_page_${n}_end), ${gzip}}},\n")
    math(EXPR n "${n} + 1")
  endforeach()
endif()
file(WRITE ${OUT}/embedded_page.cpp "#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include \"polyarm/server/assets.hpp\"

${data}
namespace polyarm::server {

namespace {
[[maybe_unused]] std::string_view view(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}
}  // namespace

const std::map<std::string, Asset>& embedded_page() {
  static const std::map<std::string, Asset> files = {
${rows}  };
  return files;
}

}  // namespace polyarm::server
")
