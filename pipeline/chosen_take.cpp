#include "pipeline/chosen_take.h"

#include <algorithm>

#include "core/text.h"
#include "pipeline/label_record.h"
#include "pipeline/made_files.h"
#include "pipeline/scene_loader.h"
#include "recon/label_volume.h"

namespace floatstage::pipeline {
namespace {

constexpr int kVoxels = 150'000;  // in the box of the hull: pixels of others are all that they decide
constexpr double kSmooth = 0.7;   // nats, two neighbours of different labels
constexpr float kNobody = 0.5F;   // nats: cameras that contradict one another speak of nobody

class ChosenTake final : public capture::TakeReader {
 public:
  ChosenTake(std::unique_ptr<capture::TakeReader> whole, TakeLayout layout)
      : whole_(std::move(whole)), layout_(std::move(layout)) {}

  const TakeLayout& layout() const override { return layout_; }
  const TakeManifest& manifest() const override { return whole_->manifest(); }
  const Rig& rig() const override { return whole_->rig(); }
  const std::vector<std::string>& warnings() const override { return whole_->warnings(); }
  int frame_count() const override { return whole_->frame_count(); }
  const std::vector<FrameRow>& rows(int camera) const override { return whole_->rows(camera); }
  Result<Frame> frame(int camera, int index) override { return whole_->frame(camera, index); }
  Result<Frame> part(int camera, int index, std::span<const PixelBox> boxes, PixelBox& box) override {
    return whole_->part(camera, index, boxes, box);
  }
  Result<FrameSet> frame_set(int index) override { return whole_->frame_set(index); }

 private:
  std::unique_ptr<capture::TakeReader> whole_;
  const TakeLayout layout_;
};

// No label is older than its sum.
Result<void> check_age(const TakeLayout& layout) {
  const Result<LabelRecord> record = load_label_record(layout);
  if (!record) return forward(record);
  const std::string take = layout.folder().string();
  for (const auto& [serial, frames] : record->sums)
    for (const auto& [frame, hash] : frames) {
      const Result<std::optional<std::string>> now = hash_of(layout.matte(serial, frame));
      if (!now) return forward(now);
      if (*now != hash)
        return fail(ErrorCode::NotFound,
                    text("the labels of ", take, " are older than the matte of camera '", serial, "', frame ",
                         frame, "; run `floatstage matte ", take, "`"));
    }
  return {};
}

// Of each pixel that is somebody's, who: 1 the chosen, 2 others.
std::vector<float> says_of(const Matte& sum, const Matte& chosen) {
  std::vector<float> says(2 * static_cast<std::size_t>(sum.width) * static_cast<std::size_t>(sum.height),
                          0.F);
  for (int y = 0; y < sum.height; ++y)
    for (int x = 0; x < sum.width; ++x) {
      if (sum.row(y)[x] < 128) continue;
      const bool theirs = 2 * chosen.row(y)[x] >= sum.row(y)[x];
      float* said = says.data() + 2 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(sum.width) +
                                       static_cast<std::size_t>(x));
      said[0] = theirs ? 1.F : -1.F, said[1] = -said[0];
    }
  return says;
}

}  // namespace

Result<std::unique_ptr<capture::TakeReader>> choose(std::unique_ptr<capture::TakeReader> take,
                                                    const LabelChoice& choice) {
  if (choice.everybody()) return take;
  Result<TakeLayout> layout = choose_labels(take->layout(), choice.only, choice.without);
  if (!layout) return forward(layout);
  if (Result<void> ok = check_age(*layout); !ok) return forward(ok);
  return std::unique_ptr<capture::TakeReader>(new ChosenTake(std::move(take), std::move(*layout)));
}

Result<std::unique_ptr<capture::TakeReader>> open_chosen(const std::filesystem::path& take,
                                                         const LabelChoice& choice) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take);
  if (!opened) return opened;
  return choose(std::move(*opened), choice);
}

Result<std::vector<Matte>> silhouettes_of_labels(const capture::TakeReader& take, int frame,
                                                 std::vector<Matte> mattes, int threads) {
  if (take.layout().labels().empty()) return mattes;
  const Rig& rig = take.rig();
  const Result<std::vector<Matte>> sums = load_sums(take, frame);
  if (!sums) return forward(sums);
  const double edge = recon::LabelVolume::edge_for(rig, *sums, kVoxels);
  if (edge == 0) return mattes;
  const Result<recon::LabelVolume> volume = recon::LabelVolume::carve(rig, *sums, edge, 2, threads);
  if (!volume) return forward(volume);
  std::vector<std::uint8_t> voxels;
  for (int round = 0; round < 2; ++round) {  // once with all in front, once with those that are somebody's
    recon::LabelVolume::Costs costs = volume->no_costs();
    for (std::size_t v = 0; v < volume->size(); ++v) costs[3 * v] = kNobody;
    for (std::size_t c = 0; c < mattes.size(); ++c)
      if (!(*sums)[c].empty() && !mattes[c].empty())
        volume->hear(static_cast<int>(c), voxels, says_of((*sums)[c], mattes[c]), 1, costs);
    voxels = volume->label(costs, kSmooth);
  }
  for (std::uint8_t& v : voxels) v = v == 1;
  for (std::size_t c = 0; c < mattes.size(); ++c) {
    if ((*sums)[c].empty() || mattes[c].empty()) continue;
    Image seen = volume->picture(static_cast<int>(c), voxels);
    for (int y = 0; y < seen.height; ++y)
      for (int x = 0; x < seen.width; ++x) {
        const int own = mattes[c].row(y)[x], sum = (*sums)[c].row(y)[x];
        *seen.at(x, y) = static_cast<std::uint8_t>(*seen.at(x, y) && own < sum ? sum : own);
      }
    mattes[c] = make_matte(mattes[c].source, seen);
  }
  return mattes;
}

}  // namespace floatstage::pipeline
