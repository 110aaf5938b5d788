# cmake -DFILES="a;b" -DOUT=file.cpp -P embed.cmake: writes web_page_files() over the files' contents.
set(table "")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" content)
  # A literal may hold 64 KiB; these are far smaller.
  string(APPEND table "      {\"${name}\", R\"~page~(${content})~page~\"},\n")
endforeach()
file(WRITE "${OUT}.new" "// Made by pipeline/export/page/embed.cmake from the files beside it.
#include \"pipeline/export/web_page.h\"

namespace floatstage::pipeline {

std::vector<WebPageFile> web_page_files() {
  return {
${table}  };
}

}  // namespace floatstage::pipeline
")
file(COPY_FILE "${OUT}.new" "${OUT}" ONLY_IF_DIFFERENT)
