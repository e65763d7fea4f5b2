# embed_files(FOLDER OUT NAME FUNCTION PREFIX): writes OUT/NAME.cpp, which carries the files of FOLDER as
# polyarm::server::FUNCTION(), by path behind PREFIX ("/"); text is compressed. FOLDER may be empty: then there are none.
function(embed_files folder out name function prefix)
  set(data "")
  set(rows "")
  if(folder)
    file(REMOVE_RECURSE ${out}/${name})
    file(MAKE_DIRECTORY ${out}/${name})
    file(GLOB_RECURSE files RELATIVE ${folder} ${folder}/*)
    set(n 0)
    foreach(file ${files})
      set(gzip false)
      set(stored ${out}/${name}/${n})
      if(file MATCHES "[.](html|js|css|json|svg|txt|webmanifest|wasm|ico)$")
        execute_process(COMMAND gzip -9 -n -c ${folder}/${file} OUTPUT_FILE ${stored} RESULT_VARIABLE failed)
        if(NOT failed)
          set(gzip true)
        endif()
      endif()
      if(NOT gzip)
        file(COPY_FILE ${folder}/${file} ${stored})
      endif()
      file(SHA256 ${stored} sum)  # so that this text changes with the file
      string(APPEND data "// ${file} ${sum}\n"
        "asm(\".section .rodata\\n.balign 16\\n${name}_${n}:\\n.incbin \\\"${stored}\\\"\\n${name}_${n}_end:\\n"
        ".byte 0\\n.previous\\n\");\n"
        "extern \"C\" const char ${name}_${n}[], ${name}_${n}_end[];\n")
      string(APPEND rows "    {\"${prefix}${file}\", {view(${name}_${n}, ${name}_${n}_end), ${gzip}}},\n")
      math(EXPR n "${n} + 1")
    endforeach()
  endif()
  file(WRITE ${out}/${name}.cpp "#include <cstddef>
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

const std::map<std::string, Asset>& ${function}() {
  static const std::map<std::string, Asset> files = {
${rows}  };
  return files;
}

}  // namespace polyarm::server
")
endfunction()
