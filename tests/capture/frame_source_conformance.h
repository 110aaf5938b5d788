#pragma once

// What every camera must do, whatever it is: a new kind of source adds one line to
// frame_source_conformance_test.cpp. Include once in a program.

#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/frame_source.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {

/// A source with its cable: one that does not end by itself.
struct PluggedSource {
  std::unique_ptr<FrameSource> source;
  std::function<void()> unplug, plug;
};

struct SourceUnderTest {
  std::string name;
  /// Makes a source that ends by itself; the folder is for its files.
  std::function<std::unique_ptr<FrameSource>(const TempFolder& folder)> make;
  std::uint64_t delivered = 0, lost = 0;  ///< what it must count by its end
  bool live = false;                      ///< a device: a second start is a later moment, not the same one
  std::function<PluggedSource(const TempFolder& folder)> make_plugged;
};

inline void PrintTo(const SourceUnderTest& source, std::ostream* out) { *out << source.name; }

class FrameSourceConformance : public testing::TestWithParam<SourceUnderTest> {
 protected:
  void SetUp() override {
    source_ = GetParam().make(folder_);
    ASSERT_NE(source_, nullptr);
  }

  StreamInfo start() {
    const Result<StreamInfo> info = source_->start();
    EXPECT_THAT(info, IsOk());
    return info ? *info : StreamInfo{};
  }

  /// All frames up to the end; timeouts are asked again.
  std::vector<Frame> play() {
    std::vector<Frame> frames;
    for (int calls = 0; calls < 10'000; ++calls) {
      Result<Frame> frame = source_->next(milliseconds(1000));
      if (frame) {
        frames.push_back(std::move(*frame));
        continue;
      }
      if (frame.error().code == ErrorCode::Timeout) continue;
      EXPECT_THAT(frame, FailsWith(ErrorCode::EndOfStream, ""));
      return frames;
    }
    ADD_FAILURE() << "the source does not end";
    return frames;
  }

  static std::vector<std::byte> bytes_of(const Frame& frame) {
    return {frame.pixels.get(), frame.pixels.get() + frame.layout.size_bytes};
  }

  TempFolder folder_;
  std::unique_ptr<FrameSource> source_;
};

TEST_P(FrameSourceConformance, RefusesNextBeforeStart) {
  EXPECT_THAT(source_->next(milliseconds(1)), FailsWith(ErrorCode::InvalidArgument, "start"));
}

TEST_P(FrameSourceConformance, RefusesToStartTwice) {
  start();
  EXPECT_THAT(source_->start(), FailsWith(ErrorCode::InvalidArgument, "already"));
  EXPECT_EQ(play().size(), GetParam().delivered) << "and goes on as if nothing had been asked";
}

TEST_P(FrameSourceConformance, RefusesNextAfterStop) {
  start();
  source_->stop();
  EXPECT_THAT(source_->next(milliseconds(1)), FailsWith(ErrorCode::InvalidArgument, "start"));
}

TEST_P(FrameSourceConformance, MayBeStoppedAtAnyTime) {
  source_->stop();
  start();
  source_->stop();
  source_->stop();
  start();
  EXPECT_EQ(play().size(), GetParam().delivered);
}

TEST_P(FrameSourceConformance, DescribesItsFramesBeforehand) {
  const StreamInfo info = start();
  EXPECT_FALSE(info.name.empty());
  EXPECT_GE(info.frame_rate, 0);
  if (info.frame_count) {
    EXPECT_EQ(static_cast<std::uint64_t>(*info.frame_count), GetParam().delivered + GetParam().lost);
  }
  for (const Frame& frame : play()) {
    ASSERT_FALSE(frame.empty()) << "lost frames are not delivered";
    EXPECT_NE(frame.info.status, FrameStatus::Lost);
    EXPECT_EQ(frame.layout, info.layout);
  }
}

TEST_P(FrameSourceConformance, NumbersFramesUpwards) {
  start();
  const std::vector<Frame> frames = play();
  std::uint64_t skipped = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    ASSERT_GT(frames[i].info.sequence, frames[i - 1].info.sequence);
    EXPECT_GT(frames[i].info.exposure_start, frames[i - 1].info.exposure_start);
    EXPECT_EQ(frames[i].info.camera, frames[0].info.camera);
    skipped += frames[i].info.sequence - frames[i - 1].info.sequence - 1;
  }
  EXPECT_LE(skipped, GetParam().lost) << "a jump of the sequence is a lost frame, and is counted";
}

TEST_P(FrameSourceConformance, CountsWhatItDeliversAndLoses) {
  start();
  EXPECT_EQ(source_->stats().delivered, 0u);
  const std::vector<Frame> frames = play();
  const SourceStats stats = source_->stats();
  EXPECT_EQ(frames.size(), GetParam().delivered);
  EXPECT_EQ(stats.delivered, GetParam().delivered);
  EXPECT_EQ(stats.lost, GetParam().lost);
  EXPECT_EQ(stats.corrupt,
            static_cast<std::uint64_t>(std::count_if(frames.begin(), frames.end(), [](const Frame& f) {
              return f.info.status == FrameStatus::Corrupt;
            })));
}

TEST_P(FrameSourceConformance, SaysAgainThatItIsOver) {
  start();
  play();
  EXPECT_THAT(source_->next(milliseconds(1)), FailsWith(ErrorCode::EndOfStream, ""));
  EXPECT_THAT(source_->next(milliseconds(1)), FailsWith(ErrorCode::EndOfStream, ""));
}

TEST_P(FrameSourceConformance, TakesATimeoutOfNothing) {
  start();
  const Result<Frame> frame = source_->next(Nanoseconds{0});
  if (!frame) {
    EXPECT_THAT(frame, FailsWith(ErrorCode::Timeout, ""));
  }
}

TEST_P(FrameSourceConformance, StartsAgainFromTheBeginning) {
  start();
  const std::vector<Frame> first = play();
  source_->stop();
  start();
  EXPECT_EQ(source_->stats().delivered, 0u);
  const std::vector<Frame> second = play();
  ASSERT_EQ(second.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(second[i].info.sequence, first[i].info.sequence);
    if (GetParam().live) {
      EXPECT_GT(second[i].info.exposure_start, first[i].info.exposure_start);
      continue;
    }
    EXPECT_EQ(second[i].info, first[i].info);
    EXPECT_EQ(bytes_of(second[i]), bytes_of(first[i])) << "frame " << i;
  }
}

TEST_P(FrameSourceConformance, LeavesFramesValidWhenItStopsAndGoes) {
  start();
  const std::vector<Frame> frames = play();
  ASSERT_FALSE(frames.empty());
  std::vector<std::vector<std::byte>> copies;
  for (const Frame& frame : frames) copies.push_back(bytes_of(frame));
  source_->stop();
  start();
  play();
  source_.reset();
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(bytes_of(frames[i]), copies[i]) << "frame " << i;
}

TEST_P(FrameSourceConformance, SaysThatItWasUnpluggedAndComesBackWhenItIsStartedAgain) {
  const PluggedSource plugged = GetParam().make_plugged(folder_);
  FrameSource& source = *plugged.source;
  for (int times = 0; times < 2; ++times) {
    ASSERT_THAT(source.start(), IsOk());
    ASSERT_THAT(source.next(milliseconds(20'000)), IsOk());
    plugged.unplug();
    Result<Frame> last = source.next(milliseconds(1000));
    for (int calls = 0; calls < 100 && (last || last.error().code == ErrorCode::Timeout); ++calls)
      last = source.next(milliseconds(1000));
    EXPECT_THAT(last, FailsWith(ErrorCode::Disconnected, "camera")) << "what was under way may still come";
    EXPECT_THAT(source.next(milliseconds(1)), FailsWith(ErrorCode::Disconnected, ""))
        << "until it is stopped";
    source.stop();
    plugged.plug();
  }
}

TEST_P(FrameSourceConformance, IsCountedFromAnotherThread) {
  start();
  std::uint64_t seen = 0;
  std::thread watcher([&] {
    for (int i = 0; i < 1000; ++i) seen = std::max(seen, source_->stats().delivered);
  });
  play();
  watcher.join();
  EXPECT_LE(seen, GetParam().delivered);
}

}  // namespace floatstage::capture
