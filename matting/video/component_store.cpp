#include "matting/video/component_store.h"

#include <algorithm>
#include <atomic>
#include <iomanip>
#include <optional>
#include <sstream>
#include <vector>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/text.h"
#include "matting/spectral/spectral_cache.h"
#include "matting/video/frame_flow.h"

namespace floatstage::matting {
namespace {

// Everything that the components depend on, but the pictures.
std::uint64_t key_of(const SpectralOptions& o, int width, int height) {
  std::ostringstream words;
  words << std::hexfloat << o.laplacian.epsilon << ' ' << o.eigenvectors << ' ' << o.components << ' '
        << o.krylov_block << ' ' << o.krylov_steps << ' ' << o.tolerance << ' ' << o.warm_steps << ' '
        << o.sparsity << ' ' << o.newton_steps << ' ' << o.newton_stride << ' ' << o.clusterings << ' '
        << o.seed << ' ' << width << ' ' << height;
  return hash_of(words.str());
}

std::uint64_t key_after(std::uint64_t key, const Image& picture) {
  return hash_of({reinterpret_cast<const char*>(picture.pixels.data()), picture.pixels.size()}, key);
}

template <class Parsed>
std::optional<Parsed> load_if_current(const std::filesystem::path& file, std::uint64_t wanted,
                                      Result<Parsed> (*parse)(std::string_view, std::uint64_t&,
                                                              std::string_view)) {
  const auto bytes = read_file(file);
  if (!bytes) return std::nullopt;
  std::uint64_t key = 0;
  auto parsed = parse(*bytes, key, file.string());
  if (!parsed || key != wanted) return std::nullopt;
  return std::move(*parsed);
}

Unexpected in_frame(int frame, const Error& error) {
  return fail(error.code, text("frame ", frame, ": ", error.message));
}

}  // namespace

std::filesystem::path ComponentStore::file(int frame, const char* extension) const {
  return folder_ / (text(std::setw(6), std::setfill('0'), frame) + extension);
}

Result<MattingComponents> ComponentStore::load(int frame) const {
  const auto path = file(frame, ".components");
  const auto bytes = read_file(path);
  if (!bytes) return forward(bytes);
  std::uint64_t key = 0;
  return parse_components(*bytes, key, path.string());
}

// A frame's key covers the frames of its run before it, because its result does.
Result<void> ComponentStore::prepare_run(int first, int last, const std::function<Result<Image>(int)>& small,
                                         const std::function<bool(int)>& done, int& made) const {
  std::optional<EigenSolver> solver;
  std::optional<EigenPairs> pairs;              // of the frame before, once they are needed
  std::optional<MattingComponents> components;  // likewise
  std::uint64_t key = key_of(options_, width_, height_);
  Image before;
  for (int frame = first; frame < last; ++frame, ++made) {
    const auto picture = small(frame);
    if (!picture) return in_frame(frame, picture.error());
    const std::uint64_t key_before = key;
    key = key_after(key, *picture);
    auto kept = load_if_current(file(frame, ".components"), key, parse_components);
    if (kept && is_there(file(frame, ".eigen"))) {
      components = std::move(kept);
      pairs.reset();
      before = *picture;
      if (done && !done(frame))
        return fail(ErrorCode::Cancelled, "stopped while matting components were made");
      continue;
    }
    if (frame > first && !pairs)
      pairs = load_if_current(file(frame - 1, ".eigen"), key_before, parse_eigenpairs);
    if (!solver) {
      auto created = EigenSolver::create(width_, height_, options_);
      if (!created) return forward(created);
      solver.emplace(std::move(*created));
    }
    auto solved = solver->solve(*picture, pairs ? &*pairs : nullptr);
    if (!solved) return in_frame(frame, solved.error());
    quantize(solved->vectors);
    std::optional<MattingComponents> followed;
    if (frame > first && components) {
      followed = std::move(*components);
      followed->alpha = carried(followed->alpha, flow_between(before, *picture));
    }
    auto found = matting_components(*solved, options_, followed ? &*followed : nullptr);
    if (!found) return in_frame(frame, found.error());
    quantize(found->alpha);
    if (const auto r = write_file(file(frame, ".eigen"), to_bytes(*solved, key)); !r) return r;
    if (const auto r = write_file(file(frame, ".components"), to_bytes(*found, key)); !r) return r;
    pairs = std::move(*solved);
    components = std::move(*found);
    before = *picture;
    if (done && !done(frame)) return fail(ErrorCode::Cancelled, "stopped while matting components were made");
  }
  return {};
}

ComponentStore::Outcome ComponentStore::prepare(int frames, int threads,
                                                const std::function<Result<Image>(int)>& small,
                                                const std::function<bool(int)>& done) const {
  const int runs = (frames + kRun - 1) / kRun;
  std::vector<int> made(static_cast<std::size_t>(runs), 0);
  std::vector<Result<void>> results(static_cast<std::size_t>(runs));
  // Runs are handed out in order, so that one after the first failure is of no use to anybody.
  std::atomic<int> failed = runs;
  parallel_for(static_cast<std::size_t>(runs), threads, [&](std::size_t run) {
    const int number = static_cast<int>(run), first = number * kRun;
    if (number > failed) return;
    results[run] = prepare_run(first, std::min(first + kRun, frames), small, done, made[run]);
    if (!results[run])
      for (int seen = failed; number < seen && !failed.compare_exchange_weak(seen, number);) {
      }
  });
  Outcome outcome;
  for (std::size_t run = 0; run < results.size(); ++run) {
    outcome.usable += made[run];
    if (results[run]) continue;
    outcome.result = std::move(results[run]);
    break;
  }
  return outcome;
}

}  // namespace floatstage::matting
