// Of fabric_registers, for yosys-smtbmc: any bus accesses and inputs, at any time.
reg started = 1'b0;
always @(posedge clock) begin
  started <= 1'b1;
  if (!started) assume (reset);
  if (started && !$past(reset)) begin
    // A latch takes every counter and every line of its clock, and nothing else changes what reads see.
    if ($past(latch)) begin
      assert (latched_count == $past(count));
      assert (latched_line == $past(line));
      assert (latched_index == $past(at_index));
      assert (latched_good == ($past(tripped) ? {ARMS{1'b0}} : $past(good)));
    end else begin
      assert (latched_count == $past(latched_count));
      assert (latched_line == $past(latched_line));
      assert (latched_index == $past(latched_index));
      assert (latched_good == $past(latched_good));
    end
    // A commit applies every current and every enable, and no other write does.
    if ($past(commit)) assert (current_uA == $past(staged_uA));
    else assert (current_uA == $past(current_uA));
    if (enable != $past(enable)) assert ((enable == {ARMS{1'b0}} && tripped) || ($past(commit) && enable == $past(staged_enable)));
    // An index takes the counters of its clock.
    if ($past(at_index[0] && !was_at_index[0])) assert (index_count[95:0] == $past(count[95:0]));
    else assert (index_count[95:0] == $past(index_count[95:0]));
  end
  // After a reset nothing is on, and the watchdog runs.
  if (started && $past(reset)) assert (enable == {ARMS{1'b0}} && watchdog_us == 32'd2000 && staged_enable == {ARMS{1'b0}} &&
      current_uA == {32 * JOINTS{1'b0}} && latched_line == 2'd0 && latched_good == {ARMS{1'b0}});
end
