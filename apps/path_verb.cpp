#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/verbs.h"
#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/export/export_path.h"
#include "pipeline/import/import_path.h"
#include "pipeline/json_report.h"
#include "pipeline/subject.h"

namespace floatstage::apps {
namespace {

struct PathArguments {
  std::filesystem::path path, take, out, json;
  double fps = 25;
  Size size{1280, 720};
  std::string up = "y", camera;
};

std::string described(const pipeline::CameraPath& path, std::size_t index) {
  const pipeline::PathKey& key = path.keys[index];
  std::string words;
  const auto say = [&](const std::string& word) { words += (words.empty() ? "" : ", ") + word; };
  if (key.take_time) say(text("take at ", *key.take_time, " s"));
  if (index + 1 < path.keys.size() && key.take_time && path.keys[index + 1].take_time == key.take_time)
    say("frozen from here");
  if (key.ease_in > 0) say(text("ease in ", key.ease_in));
  if (key.ease_out > 0) say(text("ease out ", key.ease_out));
  if (key.orbit) say(text("orbit", *key.orbit != 0 ? text(" and ", *key.orbit, " turns") : ""));
  if (key.follow) say("follows the subject");
  return words;
}

Result<void> show(const PathArguments& given) {
  const Result<pipeline::CameraPath> path = pipeline::load_path(given.path);
  if (!path) return forward(path);
  std::printf("%s: %zu keys, %.2f s\n", given.path.c_str(), path->keys.size(), path->duration());
  for (std::size_t i = 0; i < path->keys.size(); ++i) {
    const pipeline::PathKey& k = path->keys[i];
    std::printf("%5zu %8.3f s  from (%.2f, %.2f, %.2f) at (%.2f, %.2f, %.2f)  %.1f°  %s\n", i, k.time,
                k.eye.x(), k.eye.y(), k.eye.z(), k.target.x(), k.target.y(), k.target.z(), k.fov_y,
                described(*path, i).c_str());
  }
  if (given.json.empty()) return {};
  return pipeline::save_json({{"keys", path->keys.size()},
                              {"seconds", path->duration()},
                              {"follows", path->follows()},
                              {"take_times", path->has_take_times()}},
                             given.json);
}

Result<pipeline::SubjectTrack> track_of(const PathArguments& given) {
  if (given.take.empty())
    return fail(ErrorCode::InvalidArgument,
                text(given.path.string(), " follows a take's subject; name the take with --take"));
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  Result<pipeline::Subject> subject = pipeline::find_subject(**take);
  if (!subject) return forward(subject);
  return std::move(subject->track);
}

Result<void> write(const PathArguments& given) {
  const Result<pipeline::CameraPath> path = pipeline::load_path(given.path);
  if (!path) return forward(path);
  const Result<pipeline::SubjectTrack> track =
      path->follows() ? track_of(given) : Result<pipeline::SubjectTrack>(pipeline::SubjectTrack());
  if (!track) return forward(track);
  const std::vector<pipeline::FilmCamera> cameras = pipeline::film_cameras(
      *path, given.fps, *track,
      pipeline::names_a_gltf(given.out) ? pipeline::FilmTimes::WithEnd : pipeline::FilmTimes::Pictures);
  if (Result<void> ok =
          pipeline::export_path(cameras, given.size.width, given.size.height, given.up == "z", given.out);
      !ok)
    return ok;
  std::printf("%s: %zu cameras over %.2f s\n", given.out.c_str(), cameras.size(), path->duration());
  if (given.json.empty()) return {};
  return pipeline::save_json(
      {{"out", given.out.string()}, {"cameras", cameras.size()}, {"seconds", path->duration()}}, given.json);
}

Result<void> read(const PathArguments& given) {
  const Result<pipeline::CameraPath> path = pipeline::import_path(
      {.from = given.path, .frame_rate = given.fps, .z_up = given.up == "z", .camera = given.camera});
  if (!path) return forward(path);
  if (is_there(given.out))
    return fail(ErrorCode::AlreadyExists,
                text(given.out.string(), ": is there already, and is left as it is; give another --out"));
  if (Result<void> ok = pipeline::save_path(*path, given.out); !ok) return ok;
  std::printf("%s: %zu keys over %.2f s\n", given.out.c_str(), path->keys.size(), path->duration());
  if (given.json.empty()) return {};
  return pipeline::save_json(
      {{"out", given.out.string()}, {"keys", path->keys.size()}, {"seconds", path->duration()}}, given.json);
}

void add_up(CLI::App& verb, std::string& up) {
  verb.add_option("--up", up, "Of glTF, the axis that points upwards: y as it has it, z to leave coordinates")
      ->capture_default_str()
      ->check(one_of({"y", "z"}));
}

void add_show(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<PathArguments>();
  CLI::App* verb =
      add_verb(parent, chosen, "show", "What a camera path's keys say",
               {"floatstage path show path.json", "floatstage path show path.json --json path-report.json"});
  verb->add_option("path", options->path, "A camera path, of `play` or `path import`")
      ->required()
      ->type_name("FILE");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return show(*options); }; });
}

void add_write(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<PathArguments>();
  CLI::App* verb = add_verb(parent, chosen, "export", "A camera path as a glTF camera, or as COLMAP's images",
                            {"floatstage path export path.json -o camera.glb",
                             "floatstage path export path.json --size 1920x1080 --fps 50 -o cameras"});
  verb->add_option("path", options->path, "A camera path, of `play` or `path import`")
      ->required()
      ->type_name("FILE");
  add_out(*verb, options->out, "A .gltf or .glb; else a new folder, a model of COLMAP")->required();
  add_fps(*verb, options->fps, "Cameras a second of the film");
  add_size(*verb, options->size, "Size of COLMAP's pictures");
  verb->add_option("--take", options->take, "The take, for a path that follows its subject")
      ->type_name("PATH");
  add_up(*verb, options->up);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return write(*options); }; });
}

void add_read(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<PathArguments>();
  CLI::App* verb =
      add_verb(parent, chosen, "import", "The moving camera of a glTF, or COLMAP's images → path",
               {"floatstage path import camera.glb -o path.json",
                "floatstage path import sparse/0 --fps 30 -o path.json"});
  verb->add_option("from", options->path, "A .gltf or .glb, or a folder with COLMAP's cameras and images")
      ->required()
      ->type_name("PATH");
  add_out(*verb, options->out, "The camera path, a new file")->required();
  add_fps(*verb, options->fps, "Of COLMAP: images a second");
  verb->add_option("--camera", options->camera,
                   "Of glTF: the node's or the camera's name, where several move")
      ->type_name("NAME");
  add_up(*verb, options->up);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return read(*options); }; });
}

}  // namespace

void add_path(CLI::App& app, Chosen& chosen) {
  CLI::App* verb =
      add_verb(app, chosen, "path", "Camera paths: what they say, to and from other programs",
               {"floatstage path show path.json", "floatstage path export path.json -o camera.glb"});
  verb->require_subcommand(1);
  add_show(*verb, chosen);
  add_write(*verb, chosen);
  add_read(*verb, chosen);
}

}  // namespace floatstage::apps
