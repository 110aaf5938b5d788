# Writes the page's files into one header as string literals: cmake -DFOLDER=… -DOUT=… -P embed.cmake
set(text "// Made from studio/page/site by the build.\n#pragma once\n\n#include <string_view>\n\nnamespace floatstage::studio::page {\n\n")
foreach(file Html:page.html Css:page.css Js:page.js Focus:focus.js)
  string(REPLACE ":" ";" file ${file})
  list(GET file 0 name)
  list(GET file 1 path)
  file(READ ${FOLDER}/${path} content)
  # A literal may hold 64 KiB; these are far smaller.
  string(APPEND text "inline constexpr std::string_view k${name} = R\"~page~(${content})~page~\";\n\n")
endforeach()
string(APPEND text "}  // namespace floatstage::studio::page\n")
file(WRITE ${OUT}.new "${text}")
file(COPY_FILE ${OUT}.new ${OUT} ONLY_IF_DIFFERENT)
