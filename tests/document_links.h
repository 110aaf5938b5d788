#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace floatstage::architecture {

/// A link of a Markdown file to a file beside it: [text](target#heading). Those to other sites are none.
struct DocumentLink {
  std::string target;   ///< as written; empty: the file itself
  std::string heading;  ///< after '#', or nothing
  int line = 0;         ///< from 1
};

/// The links and pictures of a document; what stands in fences or between backticks does not count.
std::vector<DocumentLink> links_of(std::string_view markdown);

/// What a link calls the headings of a document: "## Who calls whom" is "who-calls-whom".
std::vector<std::string> anchors_of(std::string_view markdown);

struct Document {
  std::string path;  ///< from the root, with forward slashes
  std::string text;
};

/// One sentence for each link that leads to no file, or to no heading of a document. `exists` is asked with
/// paths from the root.
std::vector<std::string> broken_links(const std::vector<Document>& documents,
                                      const std::function<bool(const std::string&)>& exists);

}  // namespace floatstage::architecture
