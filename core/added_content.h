#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/image.h"

namespace floatstage {

/// What a camera, a recorder or a converter put over what the lens saw, at one place in all pictures of a
/// camera: bars along the sides (letter boxes, dead columns), and time stamps, names and logos.
struct AddedContent {
  int left = 0, top = 0, right = 0, bottom = 0;  ///< px: rows and columns of the bars
  std::vector<PixelBox> overlays = {};           ///< px, inside of the bars

  bool bars() const { return left + top + right + bottom > 0; }
  bool none() const { return !bars() && overlays.empty(); }
  bool operator==(const AddedContent&) const = default;
};

/// The rectangle that the bars leave of a picture of this size; empty where they leave nothing.
PixelBox inside(const AddedContent& added, int width, int height);

/// Of a picture of this size where the lens has seen: 255, and 0 where something was added; 1 channel.
Image seen_by_lens(const AddedContent& added, int width, int height);

/// The picture with what was added replaced by what is around it: overlays by the colours at their four
/// sides, the nearer the more; bars by the row or column next to them. What goes on behind a stamp is thus
/// guessed, as smooth as can be, and nothing in it has a contour that no lens has seen. Any number of
/// channels; boxes are cut to the picture.
Image without(const AddedContent& added, Image picture);

/// "left 3 px, bottom 40 px; 2 overlays: 200x24 at (12, 8), 80x24 at (500, 8)"
std::string describe(const AddedContent& added);
/// The same of several cameras, a sentence for those to whose pictures the same was added: "cameras 'a', 'b':
/// left 3 px". Nothing for those to whose nothing was.
std::vector<std::string> describe(const std::map<std::string, AddedContent>& by_serial);

}  // namespace floatstage
