#include <charconv>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/text_options.h"
#include "apps/terminal/world_flags.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/derive/derived_take.h"
#include "pipeline/derive/sightings.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct TakeWorldArguments {
  fs::path take, out, json, board;
  pipeline::WorldOptions world;
  int frame = 0;
  double board_height = 0, length = 0;
  std::string from, to, label;
};

// "cam01:312.5:220,cam04:90:411"
Result<std::vector<pipeline::Sighting>> parse_sightings(const std::string& words, const Rig& rig,
                                                        const std::string& flag) {
  std::vector<pipeline::Sighting> seen;
  for (const std::string& word : split_list(words)) {
    const std::size_t y = word.rfind(':'), x = y == std::string::npos || y == 0 ? y : word.rfind(':', y - 1);
    pipeline::Sighting s;
    const auto number = [&](std::size_t begin, std::size_t end, double& value) {
      const char *first = word.data() + begin, *last = word.data() + end;
      const auto read = std::from_chars(first, last, value);
      return read.ec == std::errc() && read.ptr == last;
    };
    if (x == std::string::npos || x == y || !number(x + 1, y, s.pixel.x()) ||
        !number(y + 1, word.size(), s.pixel.y()))
      return fail(ErrorCode::InvalidArgument,
                  text(flag, ": '", word, "' is no place in a picture; say SERIAL:X:Y, in pixels"));
    s.camera = camera_index(rig, word.substr(0, x));
    if (s.camera < 0)
      return fail(ErrorCode::InvalidArgument, text(flag, ": there is no camera '", word.substr(0, x), "'"));
    seen.push_back(s);
  }
  return seen;
}

Result<double> scale_of(const TakeWorldArguments& given, const Rig& rig, std::string& said) {
  const Result<std::vector<pipeline::Sighting>> from = parse_sightings(given.from, rig, "--from");
  if (!from) return forward(from);
  const Result<std::vector<pipeline::Sighting>> to = parse_sightings(given.to, rig, "--to");
  if (!to) return forward(to);
  const Result<pipeline::Placed> a = pipeline::place(rig, *from, "--from");
  if (!a) return forward(a);
  const Result<pipeline::Placed> b = pipeline::place(rig, *to, "--to");
  if (!b) return forward(b);
  const double was = (b->point - a->point).norm();
  if (!(was > 0))
    return fail(ErrorCode::InvalidArgument, "--from and --to are the same point: that tells no length");
  said = text("the length was ", was, " m and is ", given.length, " m now; its ends miss their marks by ",
              a->error, " and ", b->error, " px");
  return given.length / was;
}

Result<pipeline::WorldChange> by_board(const TakeWorldArguments& given, capture::TakeReader& take,
                                       std::string& said) {
  const Result<calib::TargetDesign> board = calib::load_target(given.board);
  if (!board) return forward(board);
  const Result<pipeline::BoardWorld> world =
      pipeline::world_from_board(take, *board, given.frame, given.board_height);
  if (!world) return forward(world);
  said = text(world->cameras, " cameras saw ", world->points, " points of the board, which they miss by ",
              1000 * world->rms, " mm; lengths become ", world->change.scale, " times what they were");
  return world->change;
}

Result<pipeline::WorldChange> change_of(const TakeWorldArguments& given, capture::TakeReader& take,
                                        std::string& said) {
  if (!given.board.empty()) return by_board(given, take, said);
  pipeline::WorldOptions world = given.world;
  if (given.length > 0) {
    const Result<double> scale = scale_of(given, take.rig(), said);
    if (!scale) return forward(scale);
    world.scale = *scale;
  }
  return pipeline::world_change(take.rig(), world);
}

Result<void> check(const TakeWorldArguments& given) {
  const bool marks = !given.from.empty() || !given.to.empty() || given.length > 0;
  if (marks && (given.from.empty() || given.to.empty() || given.length <= 0))
    return fail(ErrorCode::InvalidArgument, "a marked length is --length M with --from and --to, all three");
  if (!given.board.empty() && (marks || !given.world.empty()))
    return fail(ErrorCode::InvalidArgument,
                "--board says up, floor and scale by itself; leave the others out");
  if (marks && given.world.scale)
    return fail(ErrorCode::InvalidArgument, "--length and --scale both say the scale; leave one out");
  if (given.board.empty() && !marks && given.world.empty())
    return fail(ErrorCode::InvalidArgument,
                "say what is known of the world: --board, or --length, --up, --scale, --floor");
  return {};
}

Result<void> run_take_world(const TakeWorldArguments& given) {
  if (Result<void> ok = check(given); !ok) return ok;
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  if (given.frame < 0 || given.frame >= (*take)->frame_count())
    return fail(ErrorCode::InvalidArgument,
                text("frame ", given.frame, " is not in the take, which has ", (*take)->frame_count()));
  std::string said;
  const Result<pipeline::WorldChange> change = change_of(given, **take, said);
  if (!change) return forward(change);
  const Rig rig = pipeline::in_world((*take)->rig(), *change);
  const Result<pipeline::DerivedReport> report =
      pipeline::derive_take(**take, {.rig = rig, .how = "set-world", .label = given.label}, given.out);
  if (!report) return forward(report);
  for (const std::string& note : report->notes) log::info(note);
  if (!said.empty()) std::printf("%s\n", said.c_str());
  std::printf("%s: %s\n", given.out.c_str(), pipeline::describe_world(rig).c_str());
  if (given.json.empty()) return {};
  const Eigen::Quaterniond& q = change->rotation;
  const Eigen::Vector3d& t = change->translation;
  return pipeline::save_json({{"take", given.out.string()},
                              {"from", given.take.string()},
                              {"scale", change->scale},
                              {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                              {"translation", {t.x(), t.y(), t.z()}},
                              {"notes", report->notes}},
                             given.json);
}

}  // namespace

void add_take_set_world(CLI::App& take, Chosen& chosen) {
  auto options = std::make_shared<TakeWorldArguments>();
  CLI::App* verb = add_verb(take, chosen, "set-world",
                            "The same recording in a world with up, floor and scale, as a new take",
                            {"floatstage take set-world T --board board.txt --frame 12 -o upright",
                             "floatstage take set-world T --up ring --length 1.8 --from 01:310:95,07:288:120 "
                             "--to 01:305:640,07:290:655 -o metric"});
  add_take(*verb, options->take);
  add_out(*verb, options->out, "The new take's folder; it shares the media")->required();
  verb->add_option("--board", options->board,
                   "A board that lies on the floor, its printed line or sheet: says up, floor and scale")
      ->type_name("FILE");
  verb->add_option("--frame", options->frame, "The frame in which it lies there")
      ->capture_default_str()
      ->type_name("N");
  verb->add_option("--board-height", options->board_height, "Metres of its printed face above the floor")
      ->capture_default_str()
      ->type_name("M");
  add_world_flags(*verb, options->world);
  verb->add_option("--length", options->length, "Metres from --from to --to")
      ->check(CLI::PositiveNumber)
      ->type_name("M");
  verb->add_option("--from", options->from, "One end, in two pictures or more: SERIAL:X:Y,SERIAL:X:Y, pixels")
      ->type_name("MARKS");
  verb->add_option("--to", options->to, "The other end")->type_name("MARKS");
  verb->add_option("--label", options->label, "The new take's label (default: as it was)");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_take_world(*options); }; });
}

}  // namespace floatstage::apps
