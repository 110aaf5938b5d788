#include "core/result.h"

namespace floatstage {

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return "invalid-argument";
    case ErrorCode::NotFound:
      return "not-found";
    case ErrorCode::AlreadyExists:
      return "already-exists";
    case ErrorCode::BadData:
      return "bad-data";
    case ErrorCode::Unsupported:
      return "unsupported";
    case ErrorCode::Io:
      return "io";
    case ErrorCode::Timeout:
      return "timeout";
    case ErrorCode::Disconnected:
      return "disconnected";
    case ErrorCode::EndOfStream:
      return "end-of-stream";
    case ErrorCode::Cancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace floatstage
