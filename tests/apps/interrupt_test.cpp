// What Ctrl-C, `kill` and a closed terminal do to the program: the first asks, one that comes later ends.

#include "apps/terminal/interrupt.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

namespace floatstage::apps {
namespace {

using namespace std::chrono_literals;

// Each in a process of its own, since what was interrupted stays so.
TEST(InterruptDeathTest, AsksAndDoesNotEnd) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    EXPECT_EXIT(
        {
          watch_for_interrupts();
          const bool before = interrupted();
          std::raise(signal);
          std::_Exit(!before && interrupted() ? 0 : 1);
        },
        testing::ExitedWithCode(0), "");
}

TEST(InterruptDeathTest, IsOneOrderWhereProcessAndGroupAreSignalledAtOnce) {
  EXPECT_EXIT(
      {
        watch_for_interrupts();
        for (const int signal : {SIGINT, SIGINT, SIGTERM, SIGHUP}) std::raise(signal);
        std::_Exit(interrupted() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(InterruptDeathTest, EndsAtOnceWhenAskedAgainLater) {
  EXPECT_EXIT(
      {
        watch_for_interrupts();
        std::raise(SIGINT);
        std::this_thread::sleep_for(1100ms);
        std::raise(SIGTERM);
        std::_Exit(0);
      },
      testing::KilledBySignal(SIGTERM), "");
}

TEST(InterruptDeathTest, IsNotAReaderWhoHasGone) {
  EXPECT_EXIT(
      {
        watch_for_interrupts();
        std::raise(SIGPIPE);
        std::_Exit(interrupted() ? 1 : 0);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace floatstage::apps
