#include "firmware/link/services.h"

namespace thimble::firmware::link {

const char* name(Nrc code) noexcept {
  switch (code) {
    case Nrc::kOk:
      return "ok";
    case Nrc::kGeneralReject:
      return "general_reject";
    case Nrc::kServiceNotSupported:
      return "service_not_supported";
    case Nrc::kSubFunctionNotSupported:
      return "sub_function_not_supported";
    case Nrc::kIncorrectLength:
      return "incorrect_length";
    case Nrc::kResponseTooLong:
      return "response_too_long";
    case Nrc::kBusyRepeatRequest:
      return "busy_repeat_request";
    case Nrc::kConditionsNotCorrect:
      return "conditions_not_correct";
    case Nrc::kRequestSequenceError:
      return "request_sequence_error";
    case Nrc::kRequestOutOfRange:
      return "request_out_of_range";
    case Nrc::kAuthenticationRequired:
      return "authentication_required";
    case Nrc::kRequiredTimeDelayNotExpired:
      return "required_time_delay_not_expired";
    case Nrc::kOwnershipVerificationFailed:
      return "ownership_verification_failed";
    case Nrc::kDownloadNotAccepted:
      return "download_not_accepted";
    case Nrc::kTransferSuspended:
      return "transfer_suspended";
    case Nrc::kProgrammingFailure:
      return "programming_failure";
    case Nrc::kWrongBlockCounter:
      return "wrong_block_counter";
    case Nrc::kResponsePending:
      return "response_pending";
    case Nrc::kNotInThisSession:
      return "not_in_this_session";
  }
  return "unknown";
}

}  // namespace thimble::firmware::link
