#include "pipeline/calibrate/same_pictures.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

struct Origin {
  std::size_t camera = 0;
  fs::path file;
};

// Files of one content, by that content; content that only one file has is left out.
Result<std::map<std::string, std::vector<Origin>>> repeated(const std::vector<CameraFiles>& cameras) {
  std::map<std::uintmax_t, std::vector<Origin>> by_size;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (const fs::path& file : cameras[c].files) {
      std::error_code error;
      const std::uintmax_t size = fs::file_size(file, error);
      if (!error) by_size[size].push_back({c, file});  // who reads it will say what is wrong with it
    }
  std::map<std::string, std::vector<Origin>> out;
  for (const auto& [size, files] : by_size) {
    if (files.size() < 2) continue;
    std::map<std::string, std::vector<Origin>> by_content;
    for (const Origin& o : files) {
      const Result<std::string> bytes = read_file(o.file);
      if (!bytes) return forward(bytes);
      by_content[content_hash(*bytes)].push_back(o);
    }
    for (auto& [content, same] : by_content)
      if (same.size() > 1) out[text(size, '-', content)] = std::move(same);
  }
  return out;
}

Result<void> refuse_shared_files(const std::vector<CameraFiles>& cameras) {
  std::map<fs::path, std::size_t> owner;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (const fs::path& file : cameras[c].files) {
      std::error_code error;
      const fs::path real = fs::weakly_canonical(file, error);
      const auto [found, fresh] = owner.emplace(error ? file : real, c);
      if (!fresh && found->second != c)
        return fail(ErrorCode::InvalidArgument,
                    text("cameras '", cameras[found->second].serial, "' and '", cameras[c].serial,
                         "' were both given ", file.string(),
                         ": one picture has one camera; give each its own folder or files"));
    }
  return {};
}

struct Pair {
  int count = 0;
  Origin a, b;  // the first two that are the same
};

std::string sentence(const Pair& p, const std::vector<CameraFiles>& cameras) {
  return text("cameras '", cameras[p.a.camera].serial, "' and '", cameras[p.b.camera].serial, "' have ",
              p.count, p.count == 1 ? " picture" : " pictures", " that are the same byte for byte (",
              p.a.file.string(), " and ", p.b.file.string(), ")");
}

}  // namespace

Result<std::vector<std::string>> notice_same_pictures(const std::vector<CameraFiles>& cameras) {
  if (Result<void> ok = refuse_shared_files(cameras); !ok) return forward(ok);
  const auto contents = repeated(cameras);
  if (!contents) return forward(contents);
  std::map<std::pair<std::size_t, std::size_t>, Pair> pairs;
  std::map<std::size_t, Pair> twice;
  for (const auto& [content, files] : *contents) {
    std::set<std::pair<std::size_t, std::size_t>> counted;
    for (std::size_t i = 0; i < files.size(); ++i)
      for (std::size_t k = i + 1; k < files.size(); ++k) {
        const auto who = std::minmax(files[i].camera, files[k].camera);
        if (!counted.insert(who).second) continue;
        Pair& p = who.first == who.second ? twice[who.first] : pairs[who];
        if (p.count++ == 0) p = {1, files[i], files[k]};
      }
  }
  std::vector<std::string> remarks;
  for (const auto& [who, p] : pairs) {
    const std::size_t fewer = std::min(cameras[who.first].files.size(), cameras[who.second].files.size());
    if (2 * static_cast<std::size_t>(p.count) >= fewer)
      return fail(ErrorCode::InvalidArgument,
                  text(sentence(p, cameras),
                       ": a folder was copied or a recording mixed up; give each camera "
                       "what it took"));
    remarks.push_back(sentence(p, cameras) + "; is one of them another camera's?");
  }
  for (const auto& [camera, p] : twice)
    remarks.push_back(text("camera '", cameras[camera].serial, "' was given ", p.count,
                           p.count == 1 ? " picture" : " pictures", " more than once (", p.a.file.string(),
                           " and ", p.b.file.string(), "): such pictures count double and say nothing new"));
  return remarks;
}

}  // namespace floatstage::pipeline
