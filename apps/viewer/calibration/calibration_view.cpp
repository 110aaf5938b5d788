#include "apps/viewer/calibration/calibration_view.h"

#include <algorithm>
#include <cmath>
#include <iomanip>

#include <GLFW/glfw3.h>
#include <imgui.h>

#include "apps/viewer/window/window.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

constexpr ImU32 kFrame = IM_COL32(110, 115, 125, 255), kEmpty = IM_COL32(45, 48, 54, 255),
                kPoint = IM_COL32(255, 214, 90, 255), kGood = IM_COL32(60, 160, 95, 255);

const calib::CameraQuality* quality_of(const LiveStatus& status, const std::string& serial) {
  if (!status.solution) return nullptr;
  for (const calib::CameraQuality& q : status.solution->cameras)
    if (q.serial == serial) return &q;
  return nullptr;
}

// The picture's cells, greener the more points they have, and where the target is now.
void draw_camera(const LiveStatus& status, std::size_t c, float width) {
  const calib::CameraCoverage& coverage = status.coverage.cameras[c];
  const auto [w, h] = status.sizes[c];
  const ImVec2 size(width, width * static_cast<float>(h) / static_cast<float>(w)),
      at = ImGui::GetCursorScreenPos();
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const float cw = size.x / calib::kCoverageColumns, ch = size.y / calib::kCoverageRows;
  for (int row = 0; row < calib::kCoverageRows; ++row)
    for (int column = 0; column < calib::kCoverageColumns; ++column) {
      const int n = coverage.cells[static_cast<std::size_t>(row * calib::kCoverageColumns + column)];
      const float full = std::min(1.f, std::log2(1.f + static_cast<float>(n)) / 6.f);
      const ImU32 color = n == 0
                              ? kEmpty
                              : IM_COL32(static_cast<int>(50 + 10 * full), static_cast<int>(80 + 90 * full),
                                         static_cast<int>(70 + 30 * full), 255);
      const ImVec2 a(at.x + cw * static_cast<float>(column), at.y + ch * static_cast<float>(row));
      draw->AddRectFilled(a, ImVec2(a.x + cw - 1, a.y + ch - 1), color);
    }
  draw->AddRect(at, ImVec2(at.x + size.x, at.y + size.y), kFrame);
  if (c < status.instant.detections.size())
    for (const calib::SeenPoint& p : status.instant.detections[c].points)
      draw->AddCircleFilled(ImVec2(at.x + size.x * static_cast<float>(p.pixel.x() / w),
                                   at.y + size.y * static_cast<float>(p.pixel.y() / h)),
                            2.f, kPoint);
  ImGui::Dummy(size);
  ImGui::Text("%s   %d views   %.0f %%", coverage.serial.c_str(), coverage.views, 100 * coverage.covered);
  ImGui::Text("distances x %.1f   turned %d   leaned %d", coverage.depth_ratio(), coverage.turned,
              coverage.leaned);
  if (const calib::CameraQuality* q = quality_of(status, coverage.serial))
    ImGui::TextUnformatted(text(short_words(q->rms_px, 2, " px"), "   focal +- ", std::fixed,
                                std::setprecision(1), q->intrinsics_sigma[0], " px   +- ",
                                short_words(q->position_sigma_mm, 2, " mm"))
                               .c_str());
  else
    ImGui::TextDisabled("not solved yet");
}

void draw_cameras(const LiveStatus& status, float width) {
  const auto n = static_cast<int>(status.serials.size());
  const int columns = std::clamp(static_cast<int>(std::ceil(std::sqrt(static_cast<double>(n)))), 1, 4);
  const float each = width / static_cast<float>(columns) - 14;
  for (int i = 0; i < n; ++i) {
    if (i % columns != 0) ImGui::SameLine();
    ImGui::BeginGroup();
    draw_camera(status, static_cast<std::size_t>(i), each);
    ImGui::EndGroup();
    if (i % columns == columns - 1) ImGui::Spacing();
  }
}

// Who saw the target together with whom.
void draw_links(const LiveStatus& status) {
  const auto n = static_cast<int>(status.serials.size());
  if (!ImGui::BeginTable("links", n + 1, ImGuiTableFlags_SizingFixedFit)) return;
  ImGui::TableNextColumn();
  for (const std::string& serial : status.serials) {
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(serial.c_str());
  }
  for (int a = 0; a < n; ++a) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(status.serials[static_cast<std::size_t>(a)].c_str());
    for (int b = 0; b < n; ++b) {
      ImGui::TableNextColumn();
      const int frames = status.coverage.common[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
      if (a == b)
        ImGui::TextDisabled("-");
      else if (frames == 0)
        ImGui::TextDisabled("0");
      else
        ImGui::Text("%d", frames);
    }
  }
  ImGui::EndTable();
}

void draw_side(const LiveStatus& status, bool& floor) {
  ImGui::Text("%d of %d instants counted", status.counted, status.sets);
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kGood);
  ImGui::ProgressBar(static_cast<float>(status.completeness), ImVec2(-1, 0));
  ImGui::PopStyleColor();
  ImGui::Spacing();
  ImGui::TextUnformatted("What to show next");
  ImGui::Separator();
  constexpr std::size_t kShown = 7;
  for (std::size_t i = 0; i < std::min(kShown, status.advice.size()); ++i) {
    if (i > 0) ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(160, 165, 175, 255));
    ImGui::TextWrapped("%s", status.advice[i].sentence.c_str());
    if (i > 0) ImGui::PopStyleColor();
  }
  if (status.advice.empty())
    ImGui::TextWrapped("Enough. Lay the target on the floor, press the button, and close the window.");
  ImGui::Spacing();
  floor = ImGui::Button("it lies on the floor now");
  ImGui::Spacing();
  ImGui::TextUnformatted("Seen together");
  ImGui::Separator();
  draw_links(status);
  if (status.solution) {
    ImGui::Spacing();
    ImGui::Text("solved from %d instants", status.solution_sets);
    if (status.solution->scale.count > 0)
      ImGui::Text("known lengths: RMS %.2f mm", status.solution->scale.rms_mm);
    for (const calib::NamedFailure& f : status.solution->failures)
      ImGui::TextWrapped("%s: %s", name_of(f.kind), f.sentence.c_str());
  }
  if (!status.trouble.empty()) ImGui::TextWrapped("%s", status.trouble.c_str());
}

}  // namespace

Result<void> show_live(LiveRun& run, const LiveViewOptions& options,
                       const std::function<bool()>& interrupted) {
  Result<std::unique_ptr<Window>> window =
      Window::open("floatstage calibrate live", options.width, options.height);
  if (!window) return forward(window);
  int after_end = 0;
  while (!(*window)->should_close() && !interrupted()) {
    const LiveStatus status = run.status();
    (*window)->begin_frame(0.05);
    const ImGuiIO& io = ImGui::GetIO();
    ImGui::SetNextWindowPos(ImVec2(0, 0));
    ImGui::SetNextWindowSize(io.DisplaySize);
    ImGui::Begin("live", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
    const float side = 400;
    bool floor = false;
    ImGui::BeginChild("cameras", ImVec2(io.DisplaySize.x - side - 30, 0));
    draw_cameras(status, io.DisplaySize.x - side - 30);
    ImGui::EndChild();
    ImGui::SameLine();
    ImGui::BeginChild("side", ImVec2(side, 0));
    draw_side(status, floor);
    ImGui::EndChild();
    ImGui::End();
    if (floor) run.set_floor(0);
    after_end += status.settled;
    const bool last = !options.screenshot.empty() && after_end > 2;  // a user interface settles in two frames
    Image picture;
    (*window)->end_frame(last ? &picture : nullptr);
    if (last) return save_png(picture, options.screenshot);
  }
  return {};
}

std::string describe_live(const LiveStatus& status) {
  std::string out = text(status.counted, " of ", status.sets, " instants counted, ", std::fixed,
                         std::setprecision(0), 100 * status.completeness, " % of what is wanted");
  for (const calib::CameraCoverage& c : status.coverage.cameras) {
    out += text("\n  ", c.serial, ": ", c.views, " views, ", std::fixed, std::setprecision(0),
                100 * c.covered, " % of its picture, distances x ", std::setprecision(1), c.depth_ratio(),
                ", turned ", c.turned, ", leaned ", c.leaned);
    if (const calib::CameraQuality* q = quality_of(status, c.serial))
      out += text(", ", short_words(q->rms_px, 2, " px"), ", focal ± ", std::setprecision(1),
                  q->intrinsics_sigma[0], " px");
  }
  if (!status.trouble.empty()) out += "\n  " + status.trouble;
  out += "\n  next: " + (status.advice.empty() ? std::string("enough") : status.advice.front().sentence);
  return out;
}

}  // namespace floatstage::apps
