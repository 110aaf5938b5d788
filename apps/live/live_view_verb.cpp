#include "apps/live/live_verbs.h"
#include "apps/live/live_viewing.h"
#include "studio/live/live_remote.h"

namespace floatstage::apps {
namespace {

struct LiveViewArguments {
  studio::LiveRemoteOptions remote;
  LiveViewing viewing;
};

Result<void> run_live_view(const LiveViewArguments& given) {
  LiveViewing viewing = given.viewing;
  if (Result<void> ok = settle(viewing); !ok) return ok;
  const Result<studio::LiveRemote> remote = studio::open_live_remote(given.remote);
  if (!remote) return forward(remote);
  std::vector<studio::StudioControl*> nodes;
  for (const auto& node : remote->control) nodes.push_back(node.get());
  return view_scenes(*remote->scenes, remote->scenes.get(), std::move(nodes), viewing);
}

}  // namespace

void add_live_view(CLI::App& live, Chosen& chosen) {
  auto options = std::make_shared<LiveViewArguments>();
  studio::LiveRemoteOptions& remote = options->remote;
  CLI::App* verb = add_verb(
      live, chosen, "view", "The machine of a studio that shows the scenes of the one with `live recon`",
      {"floatstage live view tcp://192.168.7.20:5580 --nodes tcp://192.168.7.11:5570 --rig rig.json",
       "floatstage live view tcp://recon:5580 --nodes tcp://left:5570,tcp://right:5570 --control "
       "tcp://left:5571,tcp://right:5571 --rig rig.json --keys studio.keys"});
  verb->add_option("address", remote.recon, "Address of the machine with `live recon`, tcp://…")->required();
  add_list(*verb, "--nodes", remote.nodes, "Addresses of the capture nodes")->required();
  add_list(*verb, "--control", remote.control,
           "Where the nodes answer requests, for health, record and stop (default: neither is shown)");
  verb->add_option("--rig", remote.rig, "The studio's rig.json")->required()->type_name("FILE");
  verb->add_option("--keys", remote.keys, "The studio's keys, see `floatstage keys`")->type_name("FILE");
  add_viewing_flags(*verb, options->viewing);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_live_view(*options); }; });
}

}  // namespace floatstage::apps
