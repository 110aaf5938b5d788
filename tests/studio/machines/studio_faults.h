#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "capture/take.h"
#include "core/file.h"
#include "studio/live/remote_scenes.h"
#include "studio/messages/clock.h"
#include "studio/network/control_client.h"
#include "tests/studio/machines/studio_lab.h"
#include "tests/support/eventually.h"

namespace floatstage::studio {

/// A studio of four machines that works; this process is the viewer's. Each test does something to it, and
/// everything works again in the end. Conditions are waited for, however slow the machine is.
class StudioFaults : public testing::Test {
 protected:
  static constexpr std::chrono::seconds kPatience{240};
  static constexpr int kLeft = StudioLab::kLeft, kRight = StudioLab::kRight, kView = StudioLab::kView;

  void SetUp() override {
    if (const std::string why = NetworkLab::forbidden(); !why.empty()) GTEST_SKIP() << why;
    ASSERT_TRUE(studio_.lab);
    left_ = studio_.start_node(kLeft);
    right_ = studio_.start_node(kRight);
    recon_ = studio_.start_recon();
    ASSERT_TRUE(studio_.lab->enter(kView));
    RemoteOptions options;
    options.recon = studio_.recon_address();
    options.nodes = {studio_.node_address(kLeft), studio_.node_address(kRight)};
    options.keys = studio_.keys;
    options.join.patience = milliseconds(2000);
    Result<std::unique_ptr<RemoteScenes>> scenes = RemoteScenes::open(studio_.rig, options);
    ASSERT_THAT(scenes, IsOk());
    scenes_ = std::move(*scenes);
    scenes_->want({0, 1, 2});
    ASSERT_TRUE(sees(6)) << logs();
  }

  std::string logs() const { return left_->output() + right_->output() + recon_->output(); }

  /// So many scenes come in which so many cameras took part, each scene with its surface and a texture at
  /// least.
  bool sees(std::size_t cameras, int scenes = 1) {
    return eventually(
        [&] {
          const std::shared_ptr<const LiveScene> scene = scenes_->newest(now() + milliseconds(100));
          if (scene && scene->scene.cameras.size() == cameras && !scene->scene.mesh.empty() &&
              textures(*scene) > 0)
            --scenes;
          return scenes <= 0;
        },
        kPatience);
  }

  static int textures(const LiveScene& scene) {
    int count = 0;
    for (const auto& view : scene.views) count += view ? 1 : 0;
    return count;
  }

  wire::ControlClient control(int machine) const {
    Result<std::unique_ptr<wire::ControlClient>> client =
        wire::ControlClient::connect(studio_.control_address(machine), studio_.keys, milliseconds(60'000));
    EXPECT_THAT(client, IsOk());
    return std::move(**client);
  }

  /// Begins a take on a machine and waits until all its cameras are in it; where it lies.
  std::filesystem::path record(int machine) const {
    const Result<std::string> take = control(machine).start_recording("fault");
    EXPECT_THAT(take, IsOk());
    EXPECT_TRUE(eventually([&] { return recorded(machine) >= 6; }, kPatience));
    return studio_.takes_of(machine) / (take ? *take : "");
  }

  std::uint64_t recorded(int machine) const {
    const Result<NodeStatus> status = control(machine).ask_status();
    return status && status->recording ? status->recording->frames : 0;
  }

  /// Every instant from a take's first to its last has a row: a picture that can be read, or a gap that says
  /// so.
  static void expect_no_silent_loss(const std::filesystem::path& folder, bool complete) {
    const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder);
    ASSERT_THAT(take, IsOk());
    EXPECT_EQ((*take)->manifest().complete, complete);
    for (int camera = 0; camera < 3; ++camera) {
      const std::vector<FrameRow>& rows = (*take)->rows(camera);
      EXPECT_FALSE(rows.empty()) << "camera " << camera;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].info.sequence, rows[0].info.sequence + i);
        if (!rows[i].media_index) {
          EXPECT_EQ(rows[i].info.status, FrameStatus::Lost);
          continue;
        }
        const Result<Frame> frame = (*take)->frame(camera, static_cast<int>(i));
        ASSERT_THAT(frame, IsOk());
        EXPECT_FALSE(frame->empty());
      }
    }
  }

  /// Ends a program as a service manager does; what it reports.
  nlohmann::json end(RunningProgram& program, const std::string& name) const {
    program.terminate();
    EXPECT_EQ(program.wait(), 0) << program.output();
    const Result<std::string> bytes = read_file(studio_.json_of(name));
    EXPECT_THAT(bytes, IsOk());
    return bytes ? nlohmann::json::parse(*bytes, nullptr, false) : nlohmann::json();
  }

  StudioLab studio_;
  std::unique_ptr<RunningProgram> left_, right_, recon_;
  std::unique_ptr<RemoteScenes> scenes_;
};

}  // namespace floatstage::studio
