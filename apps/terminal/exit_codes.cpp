#include "apps/terminal/exit_codes.h"

namespace floatstage::apps {

int exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return 3;
    case ErrorCode::NotFound:
      return 4;
    case ErrorCode::AlreadyExists:
      return 5;
    case ErrorCode::BadData:
      return 6;
    case ErrorCode::Unsupported:
      return 7;
    case ErrorCode::Io:
      return 8;
    case ErrorCode::Timeout:
      return 9;
    case ErrorCode::Disconnected:
      return 10;
    case ErrorCode::EndOfStream:
      return 11;
    case ErrorCode::Cancelled:
      return kExitKilled;
  }
  return kExitBug;
}

}  // namespace floatstage::apps
