#pragma once

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/rig_io.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"
#include "studio/network/keys.h"
#include "tests/support/matchers.h"
#include "tests/support/network_lab.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {

/// A studio of four machines on a switch: two capture nodes with three live synthetic cameras each, one
/// machine that reconstructs, one for the view. The programs are the real ones.
struct StudioLab {
  static constexpr int kCameras = 6, kLeft = 0, kRight = 1, kRecon = 2, kView = 3;

  TempFolder folder;
  std::unique_ptr<NetworkLab> lab = NetworkLab::forbidden().empty() ? NetworkLab::with_machines(4) : nullptr;
  Rig rig;
  wire::StudioKeys keys;

  StudioLab() {
    SyntheticRigOptions ring;
    ring.cameras = kCameras;
    ring.width = 160;
    ring.height = 120;
    rig = synthetic_rig(ring);
    EXPECT_THAT(save_rig(rig, folder / "rig.json"), IsOk());
    keys = *wire::make_keys();
    EXPECT_THAT(wire::save_keys(keys, folder / "studio.keys"), IsOk());
  }

  std::string node_address(int machine) const { return "tcp://" + lab->address(machine) + ":5570"; }
  std::string control_address(int machine) const { return "tcp://" + lab->address(machine) + ":5571"; }
  std::string recon_address() const { return "tcp://" + lab->address(kRecon) + ":5580"; }
  std::string json_of(const std::string& name) const { return (folder / (name + ".json")).string(); }

  /// Takes of a machine, recorded into a folder of its own.
  std::filesystem::path takes_of(int machine) const { return folder / text("takes", machine); }

  /// `late_ms`: its clock is behind the others'.
  std::unique_ptr<RunningProgram> start_node(int machine, int late_ms = 0) const {
    std::string config = text("[studio]\nframe_rate = 10\nrig = 'rig.json'\nname = 'node", machine,
                              "'\n[recording]\nfolder = 'takes", machine, "'\npreroll_seconds = 0",
                              "\n[publish]\nkeys = 'studio.keys'\naddress = '", node_address(machine),
                              "'\ncontrol = '", control_address(machine), "'\n");
    for (int camera = machine; camera < kCameras; camera += 2)
      config += text("[[camera]]\nserial = 'cam0", camera, "'\nsource = 'synthetic:camera=", camera,
                     "&cameras=", kCameras,
                     "&width=160&height=120&samples=1&rate=10&live=on&loop=3&late-ms=", late_ms, "'\n");
    const std::string name = text("node", machine);
    folder.write(name + ".toml", config);
    return lab->run(machine,
                    {FLOATSTAGE_PROGRAM, "capture", "--config", (folder / (name + ".toml")).string(),
                     "--json", json_of(name)},
                    (folder / (name + ".log")).string());
  }

  std::unique_ptr<RunningProgram> start_recon() const {
    return lab->run(
        kRecon,
        {FLOATSTAGE_PROGRAM, "live", "recon", recon_address(), "--nodes",
         node_address(kLeft) + "," + node_address(kRight), "--rig", (folder / "rig.json").string(), "--keys",
         (folder / "studio.keys").string(), "--longest-wait", "1000", "--json", json_of("recon")},
        (folder / "recon.log").string());
  }
};

}  // namespace floatstage::studio
