// Of fabric_enable, for yosys-smtbmc: any commits, enables, resets and writes of the watchdog, at any time.
reg [31:0] since = 32'd0;      // clocks since the last commit, at most MANY
reg [2:0] steady = 3'd0;       // clocks in which the watchdog had its present value, at most 4
reg [31:0] was_watchdog = 32'd0;
reg started = 1'b0;
localparam [31:0] US = CLOCKS_PER_US, MANY = US * 32'd5010;

always @(posedge clock) begin
  started <= 1'b1;
  if (!started) assume (reset);
  assume (watchdog_us <= 32'd5000);
  was_watchdog <= watchdog_us;
  steady <= watchdog_us != was_watchdog ? 3'd0 : steady == 3'd4 ? steady : steady + 3'd1;
  since <= reset || commit ? 32'd1 : since == MANY ? since : since + 32'd1;
  if (started) begin
    // Off in the clock after a reset, and watchdog_us after the last commit.
    if ($past(reset)) assert (enable == {ARMS{1'b0}} && pulse == {ARMS{1'b0}} && tripped);
    if (watchdog_us != 32'd0 && watchdog_us == was_watchdog && steady >= 3'd1 && since >= watchdog_us * US)
      assert (enable == {ARMS{1'b0}} && pulse == {ARMS{1'b0}} && tripped);
    assert ((pulse & ~enable) == {ARMS{1'b0}});
    // Off while tripped; and a trip ends with a commit without enables only.
    if (tripped) assert (enable == {ARMS{1'b0}});
    if ($past(tripped) && !tripped) assert ($past(commit) && $past(wanted) == {ARMS{1'b0}});
    // On by a commit only, with what it wants; and not cut while commits come in time.
    if ((enable & ~$past(enable)) != {ARMS{1'b0}}) assert ($past(commit) && enable == $past(wanted) && !$past(tripped));
    if (!$past(tripped) && tripped) assert ($past(reset) || $past(expired));
    if ($past(commit) && !$past(reset) && !$past(tripped) && !$past(expired)) assert (enable == $past(wanted));
    if (expired) assert ($past(watchdog_us) != 32'd0 && $past(since) + 32'd2 >= $past(watchdog_us) * US);
    // Of the induction: the time that the logic counts is the time since the commit.
    assert (since >= 32'd1 && since <= MANY);
    assert (clocks < 10'd1 + LAST_CLOCK || (clocks == 10'd3 && since == 32'd1));
    if (since < MANY) assert (elapsed_us <= MANY / US + 32'd1 && elapsed_us * US + {22'd0, clocks} == since + 32'd2);
    else assert (elapsed_us >= MANY / US - 32'd1);
  end
end
