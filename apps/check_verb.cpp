#include <cstdio>
#include <cstdlib>
#include <thread>

#include <chrono>

#include "apps/verbs.h"
#include "capture/media_file.h"
#include "core/file.h"
#include "core/text.h"
#include "render/gl_context.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

enum class Verdict { Pass, Warn, Fail };

struct Finding {
  Verdict verdict;
  std::string what;  ///< what was looked at, what was found, and (unless it passed) what to do
};

Finding look_at_gl() {
  Result<std::unique_ptr<GlContext>> gl = GlContext::headless();
  if (!gl) return {Verdict::Fail, "OpenGL: " + gl.error().message};
  const std::string who = (*gl)->description();
  const bool software = who.find("llvmpipe") != std::string::npos;
  return software ? Finding{Verdict::Warn, "OpenGL: " + who + "; renders on the processor, a GPU with its driver would be faster"}
                  : Finding{Verdict::Pass, "OpenGL: " + who};
}

Finding look_at_display() {
  if (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY")) return {Verdict::Pass, "display: there is one for `floatstage play`"};
  return {Verdict::Warn, "display: none; every verb but `play` works without (for a test: xvfb-run floatstage play …)"};
}

Finding look_at_processor() {
  const unsigned cores = std::thread::hardware_concurrency();
  return {cores >= 2 ? Verdict::Pass : Verdict::Warn, text("processor: ", cores, " core(s)", cores >= 2 ? "" : "; two or more are advised")};
}

// Measured, because a promise of a disk's maker is not a number: 64 MiB written and flushed.
Finding look_at_disk(const fs::path& folder) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error) return {Verdict::Fail, text("disk: cannot look at ", folder.string(), ": ", error.message(), "; name a folder with --folder")};
  constexpr std::size_t kProbe = std::size_t{64} << 20;
  const fs::path file = folder / "floatstage-disk-check.bin";
  const auto begin = std::chrono::steady_clock::now();
  Result<void> written = write_file(file, std::string(kProbe, '\x5a'));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fs::remove(file, error);
  if (!written) return {Verdict::Fail, "disk: " + written.error().message};
  const double rate = static_cast<double>(kProbe) / 1e6 / seconds, free_gb = static_cast<double>(space.available) / 1e9;
  // 8 cameras of 640×480 RGB at 25 a second, halved by FFV1.
  constexpr double kNeeded = 8 * 640 * 480 * 3 * 25 / 2e6;
  const std::string what = text("disk: ", folder.string(), " writes ", static_cast<int>(rate), " MB/s, ", static_cast<int>(free_gb), " GB free");
  if (rate < kNeeded) return {Verdict::Warn, text(what, "; eight 640x480 cameras at 25 fps need ", static_cast<int>(kNeeded), " MB/s, record to a faster disk")};
  if (free_gb < 10) return {Verdict::Warn, what + "; a minute of eight cameras takes about 6 GB, make room"};
  return {Verdict::Pass, what};
}

Finding look_at_video() {
  const fs::path file = fs::temp_directory_path() / text("floatstage-check-", std::chrono::steady_clock::now().time_since_epoch().count(), ".mp4");
  Result<std::unique_ptr<VideoWriter>> writer = VideoWriter::create(file, 64, 64, 25);
  Result<void> ok = writer ? (*writer)->write(Image(64, 64, 3)) : forward(writer);
  if (ok) ok = (*writer)->finish();
  std::error_code ignored;
  fs::remove(file, ignored);
  if (!ok) return {Verdict::Fail, "video: " + ok.error().message};
  return {Verdict::Pass, "video: H.264 can be written"};
}

Result<void> run(const fs::path& folder) {
  constexpr const char* kNames[] = {"PASS", "WARN", "FAIL"};
  int failed = 0;
  for (const Finding& f : {look_at_gl(), look_at_display(), look_at_processor(), look_at_disk(folder), look_at_video()}) {
    std::printf("%s  %s\n", kNames[static_cast<int>(f.verdict)], f.what.c_str());
    failed += f.verdict == Verdict::Fail;
  }
  if (failed) return fail(ErrorCode::Unsupported, text("this machine is not ready: ", failed, " check(s) failed"));
  return {};
}

}  // namespace

void add_check(CLI::App& app, Chosen& chosen) {
  auto folder = std::make_shared<fs::path>(".");
  CLI::App* verb = app.add_subcommand("check", "Is this machine ready? Each line says what to do");
  verb->add_option("--folder", *folder, "Where takes will be recorded")->capture_default_str();
  verb->callback([folder, &chosen] { chosen.run = [folder] { return run(*folder); }; });
}

}  // namespace floatstage
