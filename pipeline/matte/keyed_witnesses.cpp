#include "pipeline/matte/keyed_witnesses.h"

#include <algorithm>

#include "core/parallel.h"
#include "pipeline/matte/camera_key.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kWitnesses = 7;  // with the one in question eight, which bound a body well

// Nothing where the camera cannot be keyed so.
Matte keyed(capture::TakeReader& take, int camera, int frame, const std::string& word) {
  const Result<Frame> photograph = take.frame(camera, frame);
  if (!photograph || photograph->empty()) return {};
  const Result<CameraKey> key =
      word == "plate" ? CameraKey::plate(take, camera) : CameraKey::keyed(take, camera, word);
  if (!key) return {};
  const Result<Image> matte = key->key(*photograph, frame);
  return matte && !matte->empty() ? make_matte({}, *matte) : Matte();
}

}  // namespace

Result<std::vector<recon::SilhouetteAgreement>> agreement_with_keyed(capture::TakeReader& take, int frame,
                                                                     const std::vector<CameraMattes>& cameras,
                                                                     int threads) {
  std::vector<recon::SilhouetteAgreement> none;
  const std::string word = cameras.empty() ? "" : method_name(cameras.front().key);
  if (!is_keyer(word)) return none;
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  std::vector<std::size_t> others, some;
  for (std::size_t i = 0; i < mattes->size(); ++i)
    if ((*mattes)[i].empty()) others.push_back(i);
  const std::size_t wanted = std::min(kWitnesses, others.size());
  for (std::size_t k = 0; k < wanted; ++k) some.push_back(others[k * others.size() / wanted]);
  parallel_for(some.size(), threads, [&](std::size_t k) {
    (*mattes)[some[k]] = keyed(take, static_cast<int>(some[k]), frame, word);
  });
  return recon::agreement_between(take.rig(), *mattes, frame);
}

}  // namespace floatstage::pipeline
