// The real-time messages as a DBC file, the database that CAN tools read (Vector's format, as python-can, SavvyCAN and Wireshark's plugins
// have it). Generated from firmware/link/messages.def, with the faults' and the modes' names.
//
// Frames of several kinds that share an identifier are one message with a multiplexer; the signals of a kind begin with its name. Only the
// classic frames are in it: a DBC has one length for an identifier.
//
// Of the services it has only the two identifiers: a DBC cannot describe ISO-TP.
#pragma once

#include <cstdint>
#include <string>

namespace thimble::host {

// Of the controller with this node number, 1 to 127. Values are physical, in the units of the table.
[[nodiscard]] std::string dbc(std::uint8_t node);

}  // namespace thimble::host
