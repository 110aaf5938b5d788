#include "pipeline/calibrate/session_patterns.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/file_presence.h"
#include "core/rig.h"
#include "core/text.h"
#include "pipeline/import/media_files.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSteps = 100'000;  // of one comparison: a pattern of many stars must not take for ever

// Goes through both from the left; `serial` is what the word has stood for so far.
bool fits(std::string_view pattern, std::string_view name, std::string& serial, int& steps) {
  if (++steps > kMostSteps) return false;
  if (pattern.empty()) return name.empty();
  if (pattern.starts_with(kSerialWord)) {
    const std::string_view rest = pattern.substr(kSerialWord.size());
    if (!serial.empty())
      return name.starts_with(serial) && fits(rest, name.substr(serial.size()), serial, steps);
    for (std::size_t length = 1; length <= name.size(); ++length) {
      serial = name.substr(0, length);
      if (is_usable_serial(serial) && fits(rest, name.substr(length), serial, steps)) return true;
    }
    serial.clear();
    return false;
  }
  if (pattern.front() == '*') {
    for (std::size_t length = 0; length <= name.size(); ++length)
      if (fits(pattern.substr(1), name.substr(length), serial, steps)) return true;
    return false;
  }
  if (name.empty() || (pattern.front() != '?' && pattern.front() != name.front())) return false;
  return fits(pattern.substr(1), name.substr(1), serial, steps);
}

struct Fitting {
  fs::path path;
  std::string serial;
};

bool goes_first(const Fitting& a, const Fitting& b) { return natural_less(a.path.string(), b.path.string()); }

// Everything on the disk that a pattern stands for.
std::vector<Fitting> all_that_fit(const fs::path& pattern) {
  std::vector<Fitting> found = {{pattern.root_path(), ""}};
  for (const fs::path& part : pattern.relative_path()) {
    std::vector<Fitting> next;
    for (const Fitting& f : found) {
      if (!is_pattern(part)) {
        if (is_there(f.path / part)) next.push_back({f.path / part, f.serial});
        continue;
      }
      std::error_code error;
      const fs::path folder = f.path.empty() ? fs::path(".") : f.path;
      for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (name.starts_with('.') != part.string().starts_with('.')) continue;
        std::string serial = f.serial;
        int steps = 0;
        if (fits(part.string(), name, serial, steps)) next.push_back({f.path / name, serial});
      }
    }
    found = std::move(next);
  }
  std::sort(found.begin(), found.end(), goes_first);
  return found;
}

Unexpected nothing_fits(const fs::path& pattern) {
  return fail(ErrorCode::NotFound,
              text("nothing fits the pattern '", pattern.string(),
                   "' ('*' stands for any characters of a name, '?' for one, {serial} for a camera's)"));
}

bool stands_for_itself(const fs::path& p) { return !is_pattern(p) || is_there(p); }

// The files of a camera that has its serial.
Result<void> expand_files(std::vector<fs::path>& paths) {
  std::vector<fs::path> out;
  for (const fs::path& p : paths) {
    if (stands_for_itself(p)) {
      out.push_back(p);
      continue;
    }
    const std::vector<Fitting> found = all_that_fit(p);
    if (found.empty()) return nothing_fits(p);
    for (const Fitting& f : found) out.push_back(f.path);
  }
  paths = std::move(out);
  return {};
}

Result<void> expand_camera(SessionCamera& camera) {
  for (std::vector<fs::path>* paths : {&camera.images, &camera.alone, &camera.scene})
    if (Result<void> ok = expand_files(*paths); !ok)
      return fail(ok.error().code, text("camera '", camera.serial, "': ", ok.error().message));
  if (camera.video.empty() || stands_for_itself(camera.video)) return {};
  const std::vector<Fitting> found = all_that_fit(camera.video);
  if (found.empty())
    return fail(ErrorCode::NotFound,
                text("camera '", camera.serial, "': ", nothing_fits(camera.video).error_value.message));
  if (found.size() > 1)
    return fail(ErrorCode::BadData, text("camera '", camera.serial, "': both ", found[0].path.string(),
                                         " and ", found[1].path.string(), " fit its 'video'; it has one"));
  camera.video = found.front().path;
  return {};
}

struct NaturalLess {
  bool operator()(const std::string& a, const std::string& b) const { return natural_less(a, b); }
};
using BySerial = std::map<std::string, SessionCamera, NaturalLess>;

// The cameras that one with {serial} in its paths stands for.
Result<BySerial> cameras_of(const SessionCamera& pattern) {
  BySerial cameras;
  const auto camera = [&](const std::string& serial) -> SessionCamera& {
    const auto [at, is_new] = cameras.try_emplace(serial);
    if (is_new) {
      at->second.serial = serial;
      at->second.lens = pattern.lens;
      at->second.carried = pattern.carried;
    }
    return at->second;
  };
  for (const auto list : {&SessionCamera::images, &SessionCamera::alone, &SessionCamera::scene})
    for (const fs::path& p : pattern.*list) {
      const std::vector<Fitting> found = all_that_fit(p);
      if (found.empty()) return nothing_fits(p);
      for (const Fitting& f : found)
        if (!f.serial.empty()) (camera(f.serial).*list).push_back(f.path);
    }
  if (pattern.video.empty()) return cameras;
  const std::vector<Fitting> videos = all_that_fit(pattern.video);
  if (videos.empty()) return nothing_fits(pattern.video);
  for (const Fitting& f : videos) {
    fs::path& video = camera(f.serial).video;
    if (!video.empty())
      return fail(ErrorCode::BadData, text("camera '", f.serial, "': both ", video.string(), " and ",
                                           f.path.string(), " fit its 'video'; it has one"));
    video = f.path;
  }
  return cameras;
}

}  // namespace

bool is_pattern(const fs::path& path) {
  const std::string s = path.string();
  return s.find_first_of("*?") != std::string::npos || s.find(kSerialWord) != std::string::npos;
}

bool is_camera_pattern(const SessionCamera& c) {
  const auto has_word = [](const fs::path& p) { return p.string().find(kSerialWord) != std::string::npos; };
  if (has_word(c.video)) return true;
  for (const auto* list : {&c.images, &c.alone, &c.scene})
    if (std::any_of(list->begin(), list->end(), has_word)) return true;
  return false;
}

std::optional<std::string> fit(std::string_view pattern, std::string_view name) {
  std::string serial;
  int steps = 0;
  if (!fits(pattern, name, serial, steps)) return std::nullopt;
  return serial;
}

Result<void> expand_patterns(Session& session) {
  std::vector<SessionCamera> out;
  for (SessionCamera& c : session.cameras) {
    if (!c.serial.empty()) {
      if (Result<void> ok = expand_camera(c); !ok) return ok;
      out.push_back(std::move(c));
      continue;
    }
    Result<BySerial> cameras = cameras_of(c);
    if (!cameras) return forward(cameras);
    for (auto& [serial, camera] : *cameras) out.push_back(std::move(camera));
  }
  std::set<std::string> serials;
  for (const SessionCamera& c : out)
    if (!serials.insert(c.serial).second)
      return fail(ErrorCode::BadData, text("camera '", c.serial, "' stands there twice"));
  session.cameras = std::move(out);
  return {};
}

}  // namespace floatstage::pipeline
