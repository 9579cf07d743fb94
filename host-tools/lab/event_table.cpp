#include "host-tools/lab/event_table.h"

#include <cmath>

namespace thimble::host {

double time_of(const Recording& recording, const RecordedMark& mark) {
  // As a float, the period is a little off (board/sim/replay.cpp).
  const double rate_Hz = std::round(1.0 / static_cast<double>(recording.header.start.period_s));
  return static_cast<double>(mark.tick - recording.header.start.tick) / rate_Hz;
}

nlohmann::ordered_json events_json(const Recording& recording) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RecordedMark& mark : recording.marks)
    list.push_back({{"tick", mark.tick},
                    {"time_s", time_of(recording, mark)},
                    {"kind", link::name(mark.what)},
                    {"code", mark.value}});
  return list;
}

void write_events_csv(std::ostream& out, const Recording& recording) {
  out << "tick,time_s,kind,code\n";
  for (const auto& event : events_json(recording))
    out << event["tick"] << ',' << event["time_s"] << ',' << event["kind"].get<std::string>() << ','
        << event["code"] << '\n';
}

}  // namespace thimble::host
