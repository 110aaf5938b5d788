#pragma once

#include <string_view>
#include <vector>

namespace floatstage::pipeline {

/// A file of the page that plays a take (pipeline/export/page), which travels inside the program.
struct WebPageFile {
  std::string_view name, content;
};
std::vector<WebPageFile> web_page_files();

}  // namespace floatstage::pipeline
