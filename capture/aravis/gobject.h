#pragma once

#include <memory>
#include <string>

#include <arv.h>

#include "core/result.h"
#include "core/text.h"

namespace floatstage::capture {

struct GObjectUnref {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// Owns one reference of a GObject.
template <class T>
using GObjectPtr = std::unique_ptr<T, GObjectUnref>;

/// Collects the error that a GLib call may leave: arv_call(camera, error.out()).
class GlibError {
 public:
  GlibError() = default;
  ~GlibError() { g_clear_error(&error_); }
  GlibError(const GlibError&) = delete;
  GlibError& operator=(const GlibError&) = delete;

  GError** out() {
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  bool is(GQuark domain, int code) const { return g_error_matches(error_, domain, code); }
  std::string message() const { return error_ ? error_->message : "no reason given"; }

 private:
  GError* error_ = nullptr;
};

}  // namespace floatstage::capture
