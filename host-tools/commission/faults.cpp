#include "host-tools/commission/faults.h"

#include <array>
#include <stdexcept>

namespace thimble::host {
namespace {

using enum ArmFault;

constexpr std::array kTexts{
    FaultText{kLineIgnored, "line-ignored", "the drives stay enabled when the line is opened",
              "check the wiring of the line before anything else; do not go on without it"},
    FaultText{
        kNoise, "encoder-noise",
        "the encoder counts although nothing moves, or makes transitions that no encoder makes",
        "check the shield, the supply and the plug of the encoder, and lay its cable away from the motor's"},
    FaultText{kEncoderSign, "encoder-sign", "the encoder counts backwards",
              "exchange A and B at the encoder, or change the sign of the encoder in the file"},
    FaultText{kMotorSign, "motor-sign", "the motor turns backwards",
              "exchange the wires of the motor, or change the sign of the drive in the file"},
    FaultText{kEncodersSwapped, "encoders-swapped", "two encoders are exchanged",
              "exchange the plugs of the two encoders, or their ports in the file"},
    FaultText{kMotorsSwapped, "motors-swapped", "two motors are exchanged",
              "exchange the plugs of the two motors, or the ports of their drives in the file"},
    FaultText{kJointsSwapped, "joints-swapped", "two joints are exchanged, each with its encoder and motor",
              "exchange the plugs of both, or their ports in the file"},
    FaultText{kWrongCounts, "wrong-counts", "the encoder has another number of counts per turn",
              "correct counts_per_turn in the file; four counts are one line of the disc"},
    FaultText{kWrongRatio, "wrong-ratio", "the transmission has another ratio",
              "count the turns of the motor for one of the joint, and correct turns_per_turn in the file"},
    FaultText{kDeadChannel, "dead-channel",
              "one channel of the encoder is dead: it toggles and does not count",
              "check both channels of the encoder with a meter, then its plug"},
    FaultText{kDeadEncoder, "dead-encoder", "the encoder does not count",
              "check the plug and the supply of the encoder"},
    FaultText{kSlip, "slip", "the transmission slips: the same stop is at another count each time",
              "tighten the cable, the coupling and the set screws"},
    FaultText{kIndexOff, "index-off", "the home mark is at another place than the file says",
              "set the mark or the encoder's disc anew"},
    FaultText{kOpenWinding, "open-winding", "no current flows: the winding is open or the fuse is blown",
              "check fuse, plug and winding with a meter"},
    FaultText{kDeadPhase, "dead-phase", "the torque vanishes at some angles of the motor: one phase is dead",
              "check the three wires of the motor with a meter"},
    FaultText{
        kWeakMotor, "weak-motor", "the motor gives less torque for its current than the file says",
        "check the type of the motor and how its windings are connected, or correct torque_constant_N_m_A"},
    FaultText{kWrongInertia, "wrong-inertia", "the joint is heavier or lighter to turn than the file says",
              "correct the masses and inertias in the file, or look for what rubs or is missing"},
    FaultText{kWrongResistance, "wrong-resistance", "the winding has another resistance",
              "check the type of the motor and its plugs, or correct resistance_ohm"},
    FaultText{kCurrentLoop, "current-loop", "the current is not what was asked",
              "check the scale and the tuning of the amplifier"},
    FaultText{kNoMotion, "no-motion", "the joint does not move",
              "look for what blocks it, and whether the torque that is allowed here is above its friction"},
    FaultText{kUneven, "uneven", "the joint moves more easily in one direction",
              "look for what pulls at it: a cable, a spring, its weight"},
    FaultText{kFeedsEnergy, "feeds-energy", "a damper makes the arm move faster",
              "repeat the step of the motor's sign"},
    FaultText{kWrongDirection, "wrong-direction", "the tip does not move where it is pushed",
              "compare the lengths and the axes of the file with the arm"},
    FaultText{kWrongWeight, "wrong-weight", "the weight of the arm is another than the file says",
              "weigh the links and correct the bodies in the file"},
    FaultText{kStopElsewhere, "stop-elsewhere", "the stops are elsewhere than the file says",
              "measure the angles of the stops and correct the limits in the file"},
    FaultText{kNoRest, "no-rest", "the joint stays nowhere between its stops when it is let go",
              "balance it with a counterweight or a spring, or correct the bodies in the file"},
};

}  // namespace

std::span<const FaultText> fault_texts() noexcept { return kTexts; }

const FaultText& text_of(ArmFault fault) { return kTexts.at(static_cast<std::size_t>(fault)); }

ArmFault fault_named(std::string_view name) {
  for (const FaultText& text : kTexts)
    if (text.name == name) return text.fault;
  throw std::out_of_range("no fault has that name");
}

}  // namespace thimble::host
