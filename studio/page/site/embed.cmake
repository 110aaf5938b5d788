# Writes the page's files into one header as string literals: cmake -DFOLDER=… -DOUT=… -P embed.cmake
set(text "// Made from studio/page/site by the build.\n#pragma once\n\n#include <string_view>\n\nnamespace floatstage::studio::page {\n\n")
foreach(file Html Css Js)
  string(TOLOWER ${file} extension)
  file(READ ${FOLDER}/page.${extension} content)
  # A literal may hold 64 KiB; these are far smaller.
  string(APPEND text "inline constexpr std::string_view k${file} = R\"~page~(${content})~page~\";\n\n")
endforeach()
string(APPEND text "}  // namespace floatstage::studio::page\n")
file(WRITE ${OUT}.new "${text}")
file(COPY_FILE ${OUT}.new ${OUT} ONLY_IF_DIFFERENT)
