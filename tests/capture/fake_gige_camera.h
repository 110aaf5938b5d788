#pragma once

#include <filesystem>
#include <string>

#include <sys/types.h>

namespace floatstage::capture {

/// A process that speaks GigE Vision over UDP on an address of the loopback (Aravis' fake camera):
/// 127.0.0.`number`. Dies with this object.
class FakeGigeCamera {
 public:
  /// `lost_per_thousand` packets are never sent; `genicam` is the description that it hands out, if not its
  /// own.
  FakeGigeCamera(int number, const std::string& serial, int lost_per_thousand = 0,
                 const std::filesystem::path& genicam = {});
  ~FakeGigeCamera();
  FakeGigeCamera(const FakeGigeCamera&) = delete;
  FakeGigeCamera& operator=(const FakeGigeCamera&) = delete;

  /// "gige:SERIAL?address=127.0.0.N&" and the options.
  std::string uri(const std::string& options) const;
  const std::string& address() const { return address_; }
  /// The cable is pulled.
  void kill();
  /// The process stands still, as a camera that hangs; and goes on.
  void freeze();
  void thaw();

 private:
  const std::string address_, serial_;
  pid_t pid_ = -1;
};

}  // namespace floatstage::capture
