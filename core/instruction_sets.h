#pragma once

/// Which instruction sets kernels are compiled for; before any header of Highway. SSSE3 and AVX-512's Ice
/// Lake additions bring these loops nothing over their neighbours.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
