#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <nlohmann/json.hpp>

#include "apps/check/machine.h"
#include "apps/check/studio.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/verbs.h"
#include "capture/media_file.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "render/gl_context.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

using Verdict = Finding::Verdict;

Finding look_at_gl() {
  Result<std::unique_ptr<render::GlContext>> gl = render::GlContext::headless();
  if (!gl) return {Verdict::Warn, "OpenGL: " + gl.error().message + "; pictures are drawn in native code"};
  const std::string who = (*gl)->description();
  if ((*gl)->is_software())
    return {Verdict::Warn,
            "OpenGL: " + who + "; pictures are drawn in native code, a GPU with its driver would be faster"};
  return {Verdict::Pass, "OpenGL: " + who};
}

Finding look_at_display() {
  if (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY"))
    return {Verdict::Pass, "display: there is one for `floatstage play`"};
  return {Verdict::Warn,
          "display: none; every verb but `play` works without (for a test: xvfb-run floatstage play …)"};
}

Finding look_at_processor() {
  const unsigned cores = std::thread::hardware_concurrency();
  return {cores >= 2 ? Verdict::Pass : Verdict::Warn,
          text("processor: ", cores, " core(s)", cores >= 2 ? "" : "; two or more are advised")};
}

Finding look_at_video() {
  const fs::path file =
      fs::temp_directory_path() /
      text("floatstage-check-", std::chrono::steady_clock::now().time_since_epoch().count(), ".mp4");
  Result<std::unique_ptr<capture::VideoWriter>> writer = capture::VideoWriter::create(file, 64, 64, 25);
  Result<void> ok = writer ? (*writer)->write(Image(64, 64, 3)) : forward(writer);
  if (ok) ok = (*writer)->finish();
  std::error_code ignored;
  fs::remove(file, ignored);
  if (!ok) return {Verdict::Fail, "video: " + ok.error().message};
  return {Verdict::Pass, "video: H.264 can be written"};
}

struct CheckArguments {
  fs::path folder = ".", config, json;
};

// What the machine has, whoever records.
std::vector<Finding> look_at_machine() {
  std::vector<Finding> findings = {look_at_gl(), look_at_display(), look_at_processor(), look_at_video(),
                                   look_at_sockets()};
  for (Finding& finding : look_at_mtu("/")) findings.push_back(std::move(finding));
  findings.push_back(look_at_ptp("/"));
  for (Finding& finding : look_at_clock("/")) findings.push_back(std::move(finding));
  return findings;
}

// Without a config: eight 640x480 cameras in colour at 25 a second, halved by FFV1.
std::vector<Finding> look_at_usual_studio(const fs::path& folder) {
  constexpr double kNeeded = 8.0 * 640 * 480 * 3 * 25 / 2;
  return {look_at_receive_buffers("/", std::size_t{1024} * 768),
          look_at_port("127.0.0.1", 8470, "a node's page"),
          look_at_disk(folder, kNeeded, "eight 640x480 cameras at 25 a second")};
}

Result<void> run_check(const CheckArguments& options) {
  constexpr const char* kNames[] = {"PASS", "WARN", "FAIL"};
  std::vector<Finding> findings = look_at_machine();
  Result<std::vector<Finding>> studio = options.config.empty() ? look_at_usual_studio(options.folder)
                                                               : look_at_studio(options.config, interrupted);
  if (!studio) return forward(studio);
  findings.insert(findings.end(), studio->begin(), studio->end());
  int failed = 0;
  nlohmann::json report = nlohmann::json::array();
  for (const Finding& f : findings) {
    report.push_back({{"verdict", kNames[static_cast<int>(f.verdict)]}, {"finding", f.what}});
    std::printf("%s  %s\n", kNames[static_cast<int>(f.verdict)], f.what.c_str());
    failed += f.verdict == Verdict::Fail;
  }
  if (!options.json.empty())
    if (Result<void> ok = pipeline::save_json({{"ready", failed == 0}, {"checks", report}}, options.json);
        !ok)
      return ok;
  if (failed)
    return fail(ErrorCode::Unsupported, text("this machine is not ready: ", failed, " check(s) failed"));
  return {};
}

}  // namespace

void add_check(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<CheckArguments>();
  CLI::App* verb = add_verb(app, chosen, "check", "Is this machine ready? Each line says what to do",
                            {"floatstage check --folder /takes", "floatstage check --config studio.toml"});
  verb->add_option("--folder", options->folder, "Where takes will be recorded")
      ->capture_default_str()
      ->type_name("FOLDER");
  verb->add_option("--config", options->config,
                   "A studio (TOML): starts its cameras once and measures what they need")
      ->type_name("FILE");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_check(*options); }; });
}

}  // namespace floatstage::apps
