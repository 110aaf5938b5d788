#pragma once

#include <memory>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {

/// What a camera sees when nobody is there, learnt from several photographs and then frozen: nothing that
/// happens later changes it, so an actor who stands still does not melt into it. Relearning is a call, never
/// a side effect.
struct Plate {
  Image color;  ///< RGB
  Image noise;  ///< 1 channel: standard deviation of a channel about `color`, in sixteenths of an 8-bit step
  Image confidence;  ///< 1 channel: share of the photographs that show `color` there, 0 … 255; 0: unknown

  bool empty() const { return color.empty(); }
};

struct PlateOptions {
  double agree = 12;         ///< 8-bit steps a channel within which two photographs show the same thing
  double least_noise = 1.0;  ///< 8-bit steps: a floor, since 8-bit pictures cannot say less
  int fewest = 1;  ///< photographs that must show one thing; where fewer do, nothing was ever seen behind
                   ///< whoever moved there: unknown, confidence 0, which keys as subject

  Result<void> check() const;
};

/// The mode of every pixel over the photographs: the longest stay of its colour, refined to the median of
/// what agrees with it. Photographs of the empty stage give it directly; photographs of a performance give it
/// wherever somebody moves away for as long as he stays anywhere (a temporal median needs half of the time).
/// `subjects` (empty, or one matte a photograph): pixels that are subject there are left out, which is how a
/// plate is learnt again once mattes exist. Errors: InvalidArgument when there is no photograph, or sizes
/// differ. Deterministic.
Result<Plate> learn_plate(const std::vector<Image>& photographs, const PlateOptions& options = {},
                          const std::vector<Image>& subjects = {});

/// The plate where other light falls on it: has the picture's colours (RGB of its size) wherever `mask`, one
/// channel of any size, is not 0.
Plate lit(Plate plate, const Image& picture, const Image& mask);

/// The share of a photograph (8-bit, at least a pixel) that is overexposed, white in all channels: whatever
/// is as bright before it looks the same, and no key can tell it.
double overexposed_share(const Image& photograph);

/// What a pixel is, against the plate.
enum class PlateClass : std::uint8_t {
  Plate = 0,    ///< within the noise
  Shadow = 1,   ///< the plate's colour, darker down to half
  Reflex = 2,   ///< the plate's colour, a little brighter
  Subject = 3,  ///< anything else
};

struct PlateKeyOptions {
  double sigmas = 6;  ///< of the pixel's noise that tell subject from plate
  double least = 14;  ///< 8-bit steps: no difference below this is subject, however quiet the pixel …
  double most = 48;   ///< … and every difference above this is, however noisy
  double darkest_shadow = 0.55, brightest_reflex = 1.15;  ///< of the plate's brightness

  Result<void> check() const;
};

/// One channel of PlateClass values, of the picture's size. `picture` is RGB of the plate's size (our bug
/// otherwise).
Image classify(const Plate& plate, const Image& picture, const PlateKeyOptions& options = {});

/// 255 where a picture's classes are this one, 0 elsewhere.
Image where_is(const Image& classes, PlateClass what);

/// Before clutter, clothes and skin look like the plate or its shadow in places: shadows are asked to be
/// lighter than on cloth …
PlateKeyOptions before_clutter();
/// … and the holes that remain inside a person are filled up to a fiftieth of him. A plate that was `found`
/// behind a performance holds the middle of somebody who hardly moved it: a ring is keyed, which is filled.
CleanupOptions plate_clean_up(int width, int height, bool found);

/// A keyer against a frozen plate. Its spec is "plate:<sigmas>"; made again from samples, it learns the plate
/// from them, as before_clutter().
Result<std::unique_ptr<Keyer>> make_plate_keyer(Plate plate, const PlateKeyOptions& options = {},
                                                const std::optional<CleanupOptions>& cleanup = std::nullopt);

}  // namespace floatstage::matting
