#pragma once

#include <cstddef>

namespace floatstage::studio {

/// What a thread's stack has at least, whoever makes the thread.
constexpr std::size_t kSmallestStack = std::size_t{1} << 20;

/// Whether this program's pthread_attr_setstacksize() is in force, which gives threads kSmallestStack at
/// least. civetweb asks for 100 kB a thread; glibc takes a thread's share of all libraries' thread-local
/// variables from that, OpenBLAS, glog and METIS have 120 kB of them, and no thread is made at all (ADR 136).
bool small_stacks_are_raised();

}  // namespace floatstage::studio
