#include "firmware/services/refusal.h"

#include <algorithm>
#include <cstring>

namespace thimble::firmware {

void Host::refuse(const char* reason) noexcept {
  const std::size_t length = std::min(std::strlen(reason), refusal.size() - 1);
  std::copy_n(reason, length, refusal.begin());
  refusal[length] = '\0';
}

Nrc busy(Host& host, Busy reason) noexcept {
  for (const BusyRow& row : kBusyTable)
    if (row.busy == reason) host.refuse(row.name);
  return Nrc::kBusyRepeatRequest;
}

Nrc refuse(Host& host, Conditions conditions, const char* board_lacks) noexcept {
  std::size_t at = 0;
  const auto append = [&](const char* text) {
    for (; *text != '\0' && at + 1 < host.refusal.size(); ++text) host.refusal[at++] = *text;
  };
  for (const ConditionRow& row : kConditionTable) {
    if ((conditions & row.bit) == 0) continue;
    if (at != 0) append(",");
    append(row.name);
    if (row.bit == kBoardLacks) {
      append("(");
      append(board_lacks);
      append(")");
    }
  }
  host.refusal[at] = '\0';
  return Nrc::kConditionsNotCorrect;
}

Nrc refuse(Host& host, StoreStatus status) noexcept {
  if (status != StoreStatus::kOk) host.refuse(name(status));
  switch (status) {
    case StoreStatus::kOk:
      return Nrc::kOk;
    case StoreStatus::kTooLarge:
      return Nrc::kDownloadNotAccepted;
    case StoreStatus::kNoDownload:
    case StoreStatus::kWrongOffset:
    case StoreStatus::kIncomplete:
      return Nrc::kRequestSequenceError;
    case StoreStatus::kWrongCrc:
    case StoreStatus::kRefused:
    case StoreStatus::kStorage:
      return Nrc::kProgrammingFailure;
    case StoreStatus::kBusy:
      return Nrc::kBusyRepeatRequest;
  }
  return Nrc::kGeneralReject;
}

}  // namespace thimble::firmware
