#include "tests/generality/methods.h"

#include <algorithm>

#include "core/png.h"
#include "core/take_layout.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/matte/matte_take.h"
#include "tests/support/long_tests.h"

namespace floatstage::generality {
namespace {

namespace fs = std::filesystem;

// Cameras whose truth is known, spread over the rig.
std::vector<std::size_t> cameras_for(const std::string& method, const StageSet& set) {
  std::vector<std::size_t> known, some;
  for (std::size_t i = 0; i < set.truth.size(); ++i)
    if (!set.truth[i].empty()) known.push_back(i);
  if (wants_long_tests() || method == "consistent") return known;
  const std::size_t wanted = std::min<std::size_t>(method == "spectral" ? 1 : 4, known.size());
  for (std::size_t k = 0; k < wanted; ++k) some.push_back(known[k * known.size() / wanted]);
  return some;
}

void score(Outcome& out, const std::string& serial, const Matte& matte, const Matte& truth) {
  const double one = iou(matte, truth);
  out.mean = (out.mean * out.made + one) / (out.made + 1);
  ++out.made;
  if (one <= out.worst) {
    out.worst = one;
    out.worst_camera = serial;
  }
}

void by_matte(const std::string& method, const StageSet& set, const fs::path& take,
              const std::vector<std::size_t>& cameras, Outcome& out) {
  pipeline::MatteTakeOptions options;
  options.take = take;
  options.how = method;
  options.hull_frames = 1;
  for (const std::size_t i : cameras) options.cameras.push_back(set.rig.cameras[i].serial);
  const Result<pipeline::MatteReport> report = pipeline::matte_take(options);
  if (!report) {
    out.said.push_back(report.error().message);
    return;
  }
  // A frame that was hidden, and plates that are heard by all cameras, are no doubt about mattes.
  for (const std::string& remark : report->remarks)
    if (remark.find("were added by a camera") == std::string::npos &&
        remark.find("plates were shot") == std::string::npos)
      out.said.push_back(remark);
  for (const pipeline::MatteDoubt& d : report->doubts) out.said.push_back(pipeline::sentence(d));
  for (const pipeline::CameraMattes& c : report->cameras)
    out.said.insert(out.said.end(), c.failures.begin(), c.failures.end());
  for (const std::size_t i : cameras) {
    const std::string& serial = set.rig.cameras[i].serial;
    const Result<Image> matte = load_png(TakeLayout(take).matte(serial, 0));
    if (matte) score(out, serial, make_matte({}, *matte), set.truth[i]);
  }
}

}  // namespace

std::vector<std::string> all_methods() {
  std::vector<std::string> all;
  for (const pipeline::MatteMethod& m : pipeline::matte_methods())
    if (m.name != "given") all.push_back(m.name);
  return all;
}

Outcome outcome_of(const std::string& method, const StageSet& set, const fs::path& take) {
  Outcome out;
  const std::vector<std::size_t> cameras = cameras_for(method, set);
  out.asked = static_cast<int>(cameras.size());
  fs::remove_all(TakeLayout(take).mattes());
  by_matte(method, set, take, cameras, out);
  return out;
}

}  // namespace floatstage::generality
