// The numbers of the services that host and controller share (shaped after ISO 14229-1). Append only.
#pragma once

#include <cstddef>
#include <cstdint>

namespace thimble::firmware::link {

enum class Service : std::uint8_t {
  kSession = 0x10,
  kReset = 0x11,
  kClearFaults = 0x14,
  kReadFaults = 0x19,
  kReadData = 0x22,
  kAuthentication = 0x29,
  kWriteData = 0x2E,
  kRoutine = 0x31,
  kRequestDownload = 0x34,
  kTransferData = 0x36,
  kTransferExit = 0x37,
  kTesterPresent = 0x3E,
};
inline constexpr std::uint8_t kPositive = 0x40;  // added to the service in a positive response
inline constexpr std::uint8_t kNegative = 0x7F;  // first byte of a negative response
inline constexpr std::uint8_t kSuppressPositive = 0x80;

// Why a request was refused. kOk is ours: it never travels.
enum class Nrc : std::uint8_t {
  kOk = 0x00,
  kGeneralReject = 0x10,
  kServiceNotSupported = 0x11,
  kSubFunctionNotSupported = 0x12,
  kIncorrectLength = 0x13,
  kResponseTooLong = 0x14,
  kBusyRepeatRequest = 0x21,
  kConditionsNotCorrect = 0x22,
  kRequestSequenceError = 0x24,
  kRequestOutOfRange = 0x31,
  kAuthenticationRequired = 0x34,
  kRequiredTimeDelayNotExpired = 0x37,
  kOwnershipVerificationFailed = 0x58,
  kDownloadNotAccepted = 0x70,
  kTransferSuspended = 0x71,
  kProgrammingFailure = 0x72,
  kWrongBlockCounter = 0x73,
  kResponsePending = 0x78,
  kNotInThisSession = 0x7F,
};
[[nodiscard]] const char* name(Nrc code) noexcept;  // "conditions_not_correct"

// Default: read only. Extended: parameters, routines, faults. Programming: that and downloads. Any session
// but the default ends with the place of its host (kHostTimeout_us in host_address.h).
enum class Session : std::uint8_t { kDefault = 1, kProgramming = 2, kExtended = 3 };
enum class Reset : std::uint8_t { kHard = 1, kSoft = 3 };

enum class Routine : std::uint16_t {
  kArm = 0x0201,
  kDisarm = 0x0202,
  kHome = 0x0203,
  kActivate = 0x0204,  // run the scene that was downloaded last
  // Arguments: length (4 bytes), CRC-32 (4 bytes), both big-endian. Answers how many bytes of this very image
  // the controller holds already (4 bytes): the download goes on from there.
  kPrepareDownload = 0x0205,
  // A guarded move: the arm moves by itself (firmware/sources/guarded_move.h). Start: arguments are a MoveOrder; also while
  // it holds. Stop: the arm is let go. Results: MoveSamples, in the order in which they were taken.
  kMove = 0x0206,
  kSaveParameters = 0x0207,  // as they are now, over power-off; with the motors off
  // A recording (firmware/observe/recorder.h): every tick's counts are sent, with checks of the forces. Start: with the motors off; the scene
  // begins anew. Stop. Results: RecordingStart, then a RecordingArm for each arm.
  kRecording = 0x0208,
  // A host's clock, from which a board that was off learns how far its motors have cooled. Arguments: seconds since 1970 (4 bytes,
  // big-endian).
  kTellTime = 0x0209,
  // The audit record (firmware/store/audit_log.h). Results: AuditRecords in their order, as many as fit an answer. Arguments: the number of the
  // first (4 bytes, big-endian); where that is gone, the oldest is the first. No record: there is none yet from that number on.
  kAudit = 0x020A,
  // The key that hosts need to command (service 29). Start: the argument is the key, kKeyBytes. Stop: there is none any more. With the motors off.
  kKey = 0x020B,
  // Start: takes the lease (docs/link.md), or keeps it for another 1.5 s. Stop: gives it back.
  kCommand = 0x020C,
  // The image of an arm (firmware/store/arm_store.h), downloaded as a scene is, with the motors off. Prepare: arguments are the arm (1 byte) and
  // those of kPrepareDownload; the same answer. Activate: it is the arm from the next start on.
  kPrepareArm = 0x020D,
  kActivateArm = 0x020E,
  // Torques of the axes (firmware/sources/axis_drive.h). Start: arguments are an AxisOrder; also while the last one holds. Stop: the arm is let
  // go. Results: AxisState.
  kAxes = 0x020F,
  // As kHome, but the host says where the arm is: arguments are a HomePlace. For an arm whose home is not proved, or has no index.
  kHomeAt = 0x0210,
  // Start: a recording of which the counts alone are wanted, for the commissioning of an arm: it goes on where they do not determine the forces.
  // kRecording ends it and has its results.
  kRecordCounts = 0x0211,
  // Breaks the hardware of a simulated board: arguments are an InjectedFault. No real board has it.
  kInject = 0x02F0,
};

// A self-moving arm is slow and weak: a hand that it meets takes no harm, and stops it.
inline constexpr float kMinMoveSpeed_m_s = 0.001F;
inline constexpr float kMaxMoveSpeed_m_s = 0.05F;
inline constexpr float kMinMoveForce_N = 0.2F;  // joint friction, which the limit must not take for a contact
inline constexpr float kMaxMoveForce_N = 3.0F;
inline constexpr float kMoveAcceleration_m_s2 = 0.5F;
inline constexpr float kMoveStiffness_N_m = 1000.0F;  // of the spring from the set point to the tip
inline constexpr float kMoveHostTimeout_s = 0.5F;     // without a sign of life for so long: fault host_lost
inline constexpr std::size_t kMaxMoveSamples = 192;

// Data identifiers that are not records of messages.def. Parameters: firmware/params.def.
inline constexpr std::uint16_t kDidSession = 0xF186;          // 1 byte
inline constexpr std::uint16_t kDidSerialNumber = 0xF18C;     // text
inline constexpr std::uint16_t kDidFirmwareVersion = 0xF195;  // text
inline constexpr std::uint16_t kDidArmName = 0xF1A8;          // text: the arm model
inline constexpr std::uint16_t kDidSceneName = 0xF1A9;        // text: the running scene
// Text: the solids that tips are still inside of (Inside), a line each: arm, object, name ("0 03 lamp\n").
inline constexpr std::uint16_t kDidInside = 0xF1AD;
inline constexpr std::uint16_t kDidBoardName = 0xF1AB;    // text: the board that this image is for
inline constexpr std::uint16_t kDidResetReason = 0xF1AC;  // text: why it started ("power_on", "watchdog")
// Text: what is left out because the board crashed with it: "scene", "parameters", "scene,parameters", or nothing.
inline constexpr std::uint16_t kDidSetAside = 0xF1AE;
// Text, written by the host (service 2E): the name under which it is in the audit record, as long as it has its place. 1 to kHostNameBytes
// printable ASCII characters. It proves nothing: a host may call itself anything.
inline constexpr std::uint16_t kDidHostName = 0xF1AF;
inline constexpr std::uint16_t kDidCommander = 0xF1BF;  // text: that name of the host that commands
// Text: why a request was refused last, with one of the answers 21, 22, 70 and 72: conditions
// ("dead_man_released"), a busy reason, what is wrong with the image (firmware/services/refusal.h).
inline constexpr std::uint16_t kDidRefusal = 0xF1AA;

inline constexpr std::size_t kMaxPduBytes = 4095;
inline constexpr std::uint16_t kMaxBlockBytes = kMaxPduBytes - 2;  // data of one TransferData
inline constexpr std::size_t kMaxFreezeFrames = 64;

// Bits of a fault's status byte (ISO 14229-1 D.2).
inline constexpr std::uint8_t kFaultActive = 0x01;     // latched now
inline constexpr std::uint8_t kFaultConfirmed = 0x08;  // occurred since the last clear

}  // namespace thimble::firmware::link
